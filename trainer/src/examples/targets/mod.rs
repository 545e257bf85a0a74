//! Posed meshes from a file beside a scene.

use std::path::Path;

use super::source::{extension, unknown_format};
use super::{LoadError, Split, gltf};

/// Posed meshes of one topology.
pub(super) struct Targets {
    /// V.
    pub(super) vertex_len: usize,
    /// Posed positions, N x V, frame-major.
    pub(super) vertices: Vec<[f64; 3]>,
    /// Rest positions, of a file that has them.
    pub(super) rest: Option<Vec<[f64; 3]>>,
    /// Vertex numbers of each triangle, of a file that has faces.
    pub(super) triangles: Option<Vec<[usize; 3]>>,
    /// Use of each frame, of a file that says it.
    pub(super) split: Option<Vec<Split>>,
}

/// Reads posed meshes.
///
/// # Errors
/// A [`LoadError`] that names the file at fault.
pub(super) fn read(path: &Path) -> Result<Targets, LoadError> {
    let blame = |error| LoadError { file: path.to_owned(), error };
    match extension(path).as_str() {
        "glb" | "gltf" => gltf::read_targets(path),
        _ => Err(unknown_format(path, ".glb or .gltf")),
    }
    .map_err(blame)
}
