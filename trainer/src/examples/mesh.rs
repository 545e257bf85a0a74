//! A mesh by itself.

/// A mesh of V vertices, in the file's order and units.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// Texture coordinates, V, where all corners of each vertex have the same.
    pub uv: Option<Vec<[f64; 2]>>,
}
