//! Posed meshes.

use crate::examples::Split;

/// Posed meshes of one character.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::examples) struct Targets {
    /// Vertices of every frame, V.
    pub(in crate::examples) vertex_len: usize,
    /// Posed positions, N x V, frame-major.
    pub(in crate::examples) vertices: Vec<[f64; 3]>,
    /// Rest positions, V, of a file that has them.
    pub(in crate::examples) rest: Option<Vec<[f64; 3]>>,
    /// Vertex numbers of each triangle, of a file that has faces.
    pub(in crate::examples) triangles: Option<Vec<[usize; 3]>>,
    /// Use of each frame, N, of a file that tells it.
    pub(in crate::examples) split: Option<Vec<Split>>,
}
