//! Posed meshes from files of their own, beside a rig that has the joints.

mod error;
mod mdd;
mod obj;
mod pc2;
mod points;

use std::path::{Path, PathBuf};

pub use error::TargetsError;
pub use pc2::save_pc2;

use super::source::{extension, unknown_format};
use super::{ExamplesError, LoadError, Split, gltf, npz};

/// Posed meshes of one character.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Targets {
    /// Vertices of every frame, V.
    pub(super) vertex_len: usize,
    /// Posed positions, N x V, frame-major.
    pub(super) vertices: Vec<[f64; 3]>,
    /// Rest positions, V, of a file that has them.
    pub(super) rest: Option<Vec<[f64; 3]>>,
    /// Vertex numbers of each triangle, of a file that has faces.
    pub(super) triangles: Option<Vec<[usize; 3]>>,
    /// Use of each frame, N, of a file that tells it.
    pub(super) split: Option<Vec<Split>>,
}

/// Reads posed meshes: a point cache (`.pc2`, `.mdd`), arrays (`.npz`), one of a sequence of numbered
/// `.obj` files, a folder that holds one, or a scene's own shapes (`.glb`, `.gltf`).
///
/// # Errors
/// A [`LoadError`] that names the file at fault: it cannot be read, is none of these or is damaged;
/// or it does not have the vertices and faces of the first of its sequence.
pub(super) fn read(path: &Path) -> Result<Targets, LoadError> {
    if path.is_dir() {
        return obj::read(path);
    }
    let blame = |error| LoadError { file: path.to_owned(), error };
    let bytes = || std::fs::read(path).map_err(|error| blame(ExamplesError::Read(error)));
    match extension(path).as_str() {
        "obj" => obj::read(path),
        "npz" => npz::read_targets(path).map_err(blame),
        "pc2" => pc2::parse(&bytes()?).map_err(|error| blame(error.into())),
        "mdd" => mdd::parse(&bytes()?).map_err(|error| blame(error.into())),
        "glb" | "gltf" => gltf::read_targets(path).map_err(blame),
        _ => Err(blame(unknown_format(path, ".pc2, .mdd, .npz, .glb, .gltf or .obj"))),
    }
}

/// Lists the files that [`read`] reads; the path itself where it would fail.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    let sequence = path.is_dir() || extension(path) == "obj";
    let files = sequence.then(|| obj::sequence(path).ok()).flatten();
    files.unwrap_or_else(|| vec![path.to_owned()])
}

#[cfg(test)]
mod tests;
