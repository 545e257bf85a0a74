//! The posed meshes beside a scene, by the formats of their files.

use super::npz;
use crate::examples::{LoadError, Split};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::posed_meshes::{PosedMeshes, mdd, pc2, sequence};
use crate::formats::{abc, gltf};
use std::path::{Path, PathBuf};

/// Posed meshes, and what they are for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TargetMeshes {
    /// The meshes.
    pub(super) meshes: PosedMeshes,
    /// Use of each frame, N, of a file that tells it.
    pub(super) split: Option<Vec<Split>>,
    /// Files that a sequence leaves out, by its numbers.
    pub(super) missing: Vec<String>,
}

/// Reads posed meshes: an Alembic archive (`.abc`), a point cache (`.pc2`, `.mdd`), arrays (`.npz`), one of a sequence of numbered
/// `.obj` files, a folder that holds one, or a scene as it plays (`.glb`, `.gltf`).
///
/// # Errors
/// A [`LoadError`] that names the file at fault: it cannot be read, is none of these or is damaged;
/// or it does not have the vertices and faces of the first of its sequence.
pub(super) fn read(path: &Path) -> Result<TargetMeshes, LoadError> {
    let blame = |error| LoadError { file: path.to_owned(), error };
    let ending = extension(path);
    let read = match ending.as_str() {
        _ if path.is_dir() || ending == "obj" => {
            let missing = sequence::missing(&sequence::files(path)?);
            return Ok(TargetMeshes { missing, ..sequence::read(path)?.into() });
        }
        "npz" => {
            let (meshes, split) = npz::read_posed_meshes(path).map_err(blame)?;
            return Ok(TargetMeshes { split, ..meshes.into() });
        }
        "abc" => abc::read(path),
        "pc2" => pc2::read(path),
        "mdd" => mdd::read(path),
        "glb" | "gltf" => gltf::read_posed_meshes(path),
        _ => Err(unknown_format(path, ".abc, .pc2, .mdd, .npz, .glb, .gltf or .obj")),
    };
    read.map(TargetMeshes::from).map_err(|error| blame(error.into()))
}

/// Lists the files that [`read`] reads; the path itself where it would fail.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    let is_sequence = path.is_dir() || extension(path) == "obj";
    let files = is_sequence.then(|| sequence::files(path).ok()).flatten();
    files.unwrap_or_else(|| vec![path.to_owned()])
}

impl From<PosedMeshes> for TargetMeshes {
    fn from(meshes: PosedMeshes) -> Self {
        Self { meshes, split: None, missing: Vec::new() }
    }
}
