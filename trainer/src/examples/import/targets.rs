//! Reads posed meshes that accompany a scene.

use super::npz;
use crate::Error;
use crate::examples::{Clip, FrameName, Split};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::posed_meshes::cache::{read_mdd, read_pc2};
use crate::formats::posed_meshes::{PosedMeshes, sequence};
use crate::formats::{abc, gltf};
use sinew_runtime::format::MAGNITUDE_MAX;
use std::path::{Path, PathBuf};

/// Posed meshes with their split and files.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TargetMeshes {
    /// The file, or the folder of a sequence.
    pub(super) path: PathBuf,
    /// The meshes.
    pub(super) meshes: PosedMeshes,
    /// Use of each frame, N, if the file has a split.
    pub(super) split: Option<Vec<Split>>,
    /// Names of a sequence's files, one per frame; empty for other formats.
    pub(super) files: Vec<String>,
    /// Names of files missing from a numbered sequence.
    pub(super) missing: Vec<String>,
}

/// Reads posed meshes: an Alembic archive (`.abc`), a point cache (`.pc2`, `.mdd`), arrays (`.npz`), a numbered `.obj`
/// sequence (one file or its folder), or an animated scene (`.glb`, `.gltf`).
///
/// # Errors
/// A file cannot be read, has an unknown format, is damaged, or differs in vertices or faces from the first file of its
/// sequence; the error names the file.
pub(super) fn read(path: &Path) -> Result<TargetMeshes, Error> {
    read_unnamed(path).map_err(|error| error.in_file(path))
}

/// Reads posed meshes; errors name a file only in a sequence.
fn read_unnamed(path: &Path) -> Result<TargetMeshes, Error> {
    let ending = extension(path);
    let meshes = match ending.as_str() {
        _ if path.is_dir() || ending == "obj" => {
            let files = sequence::files(path)?;
            let missing = sequence::missing(&files);
            let files = files.iter().map(|file| sequence::name_of(file)).collect();
            let meshes = sequence::read(path)?;
            return Ok(TargetMeshes { files, missing, ..TargetMeshes::new(path, meshes) });
        }
        "npz" => {
            let (meshes, split) = npz::read_posed_meshes(path)?;
            return Ok(TargetMeshes { split, ..TargetMeshes::new(path, meshes) });
        }
        "abc" => abc::read(path),
        "pc2" => read_pc2(path),
        "mdd" => read_mdd(path),
        "glb" | "gltf" => gltf::read_posed_meshes(path),
        _ => Err(unknown_format(path, ".abc, .pc2, .mdd, .npz, .glb, .gltf or .obj")),
    };
    meshes.map(|meshes| TargetMeshes::new(path, meshes))
}

impl TargetMeshes {
    pub(super) fn new(path: &Path, meshes: PosedMeshes) -> Self {
        Self { path: path.to_owned(), meshes, split: None, files: Vec::new(), missing: Vec::new() }
    }

    /// Checks that positions are finite. The rest mesh and training frames must also be within the range of a model.
    ///
    /// - `clips`: the scene's clips, which name the frames if there are no files.
    ///
    /// # Errors
    /// A position is not finite or too large; the error names the file.
    pub(super) fn check_numbers(&self, clips: &[Clip]) -> Result<(), Error> {
        let fault = |points: &[[f64; 3]], bounded: bool| {
            let most = if bounded { f64::from(MAGNITUDE_MAX) } else { f64::MAX };
            let vertex = points.iter().position(|x| !x.iter().all(|x| x.abs() <= most))?;
            Some((vertex, points[vertex].iter().all(|x| x.is_finite())))
        };
        let error = |(vertex, is_finite): (usize, bool), at: &str| {
            let fault = match is_finite {
                true => format!("exceed {MAGNITUDE_MAX:e}, the most a model can hold,"),
                false => "are not finite".to_owned(),
            };
            let words =
                format!("its vertices {fault} {at}, at vertex {vertex}: export the meshes again");
            Error::value(words).in_file(&self.path)
        };
        if let Some(fault) = self.meshes.rest.as_ref().and_then(|rest| fault(rest, true)) {
            return Err(error(fault, "at rest"));
        }
        let frames = self.meshes.vertices.chunks(self.meshes.vertex_len.max(1));
        for (frame, posed) in frames.enumerate() {
            let split = self.split.as_ref().and_then(|split| split.get(frame));
            let is_trained = split.is_none_or(|split| *split == Split::Train);
            if let Some(fault) = fault(posed, is_trained) {
                let name = match self.files.get(frame) {
                    Some(file) => format!("{frame} ({file})"),
                    None => FrameName::new(clips, frame).to_string(),
                };
                return Err(error(fault, &format!("in frame {name}")));
            }
        }
        Ok(())
    }
}

/// Lists the files that [`read`] reads; the path itself if reading would fail.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    let is_sequence = path.is_dir() || extension(path) == "obj";
    let files = is_sequence.then(|| sequence::files(path).ok()).flatten();
    files.unwrap_or_else(|| vec![path.to_owned()])
}
