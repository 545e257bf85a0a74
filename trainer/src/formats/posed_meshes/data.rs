//! Posed meshes.

/// Posed meshes of one character.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PosedMeshes {
    /// Vertices of every frame, V.
    pub(crate) vertex_len: usize,
    /// Posed positions, N x V, frame-major.
    pub(crate) vertices: Vec<[f64; 3]>,
    /// Rest positions, V, of a file that has them.
    pub(crate) rest: Option<Vec<[f64; 3]>>,
    /// Vertex numbers of each triangle, of a file that has faces.
    pub(crate) triangles: Option<Vec<[usize; 3]>>,
}
