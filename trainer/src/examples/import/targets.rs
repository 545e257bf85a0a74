//! Reads posed meshes that accompany a scene.

use super::error::ImportError;
use super::npz;
use crate::examples::{Clip, FrameName, LoadError, Split};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::posed_meshes::cache::{read_mdd, read_pc2};
use crate::formats::posed_meshes::{PosedMeshes, sequence};
use crate::formats::{abc, gltf};
use sinew_runtime::format::MAGNITUDE_MAX;
use std::path::{Path, PathBuf};

/// Posed meshes with their split and files.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TargetMeshes {
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
/// A [`LoadError`] with the file that cannot be read, has an unknown format, is damaged, or differs in vertices or
/// faces from the first file of its sequence.
pub(super) fn read(path: &Path) -> Result<TargetMeshes, LoadError> {
    let blame = |error| LoadError { file: path.to_owned(), error };
    let ending = extension(path);
    let read = match ending.as_str() {
        _ if path.is_dir() || ending == "obj" => {
            let files = sequence::files(path)?;
            let missing = sequence::missing(&files);
            let files = files.iter().map(|file| sequence::name_of(file)).collect();
            return Ok(TargetMeshes { files, missing, ..sequence::read(path)?.into() });
        }
        "npz" => {
            let (meshes, split) = npz::read_posed_meshes(path).map_err(blame)?;
            return Ok(TargetMeshes { split, ..meshes.into() });
        }
        "abc" => abc::read(path),
        "pc2" => read_pc2(path),
        "mdd" => read_mdd(path),
        "glb" | "gltf" => gltf::read_posed_meshes(path),
        _ => Err(unknown_format(path, ".abc, .pc2, .mdd, .npz, .glb, .gltf or .obj")),
    };
    read.map(TargetMeshes::from).map_err(|error| blame(error.into()))
}

impl TargetMeshes {
    /// Checks that positions are finite. The rest mesh and training frames must also be within the range of a model.
    ///
    /// - `clips`: the scene's clips, which name the frames if there are no files.
    ///
    /// # Errors
    /// [`ImportError::TargetNumber`]
    pub(super) fn check_numbers(&self, clips: &[Clip]) -> Result<(), ImportError> {
        let fault = |points: &[[f64; 3]], bounded: bool| {
            let most = if bounded { f64::from(MAGNITUDE_MAX) } else { f64::MAX };
            let vertex = points.iter().position(|x| !x.iter().all(|x| x.abs() <= most))?;
            Some((vertex, points[vertex].iter().all(|x| x.is_finite())))
        };
        let error = |(vertex, is_finite), at| ImportError::TargetNumber { is_finite, at, vertex };
        if let Some(fault) = self.meshes.rest.as_ref().and_then(|rest| fault(rest, true)) {
            return Err(error(fault, "at rest".to_owned()));
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
                return Err(error(fault, format!("in frame {name}")));
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

impl From<PosedMeshes> for TargetMeshes {
    fn from(meshes: PosedMeshes) -> Self {
        Self { meshes, split: None, files: Vec::new(), missing: Vec::new() }
    }
}
