//! Posed meshes of one character: point caches, and sequences of meshes.

pub(crate) mod cache;
pub(crate) mod sequence;
#[cfg(test)]
mod tests;

use std::ops::Range;

/// Posed meshes of one character.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PosedMeshes {
    /// Vertices of every frame, V.
    pub(crate) vertex_len: usize,
    /// Posed positions, N x V, frame-major.
    pub(crate) vertices: Vec<[f64; 3]>,
    /// Rest positions, V, if the file has them.
    pub(crate) rest: Option<Vec<[f64; 3]>>,
    /// Vertex indices of each triangle, if the file has faces.
    pub(crate) triangles: Option<Vec<[usize; 3]>>,
    /// Reference positions, V, if the file has them: the rest positions, up to a rotation and a scale of each axis.
    /// They identify the vertices.
    pub(crate) reference: Option<Vec<[f64; 3]>>,
    /// The meshes that were joined, in order, if the file names them.
    pub(crate) parts: Vec<Part>,
}

/// A mesh that was joined with others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Names of the mesh: of its node, and of the mesh itself.
    pub(crate) names: Vec<String>,
    /// Vertices of the mesh.
    pub(crate) range: Range<usize>,
}

impl PosedMeshes {
    /// Makes posed meshes from positions only (N x V, frame-major).
    pub(crate) fn bare(vertex_len: usize, vertices: Vec<[f64; 3]>) -> Self {
        Self { vertex_len, vertices, ..Self::default() }
    }

    /// Counts the frames, N.
    pub(crate) fn frame_len(&self) -> usize {
        self.vertices.len() / self.vertex_len.max(1)
    }
}
