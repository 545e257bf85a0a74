//! Posed meshes.

use std::ops::Range;

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
    /// Positions, V, of a file that has some by which its vertices may be known: those at rest, but turned and with
    /// each axis scaled as the file likes.
    pub(crate) reference: Option<Vec<[f64; 3]>>,
    /// The meshes that were joined, one after the other, of a file that names them.
    pub(crate) parts: Vec<Part>,
}

/// One of the meshes that were joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// What it is called: the node that shows it, and the mesh.
    pub(crate) names: Vec<String>,
    /// Its vertices.
    pub(crate) range: Range<usize>,
}

impl PosedMeshes {
    /// Makes posed meshes of positions alone, N x V, frame-major.
    pub(crate) fn bare(vertex_len: usize, vertices: Vec<[f64; 3]>) -> Self {
        let (rest, triangles, reference) = (None, None, None);
        Self { vertex_len, vertices, rest, triangles, reference, parts: Vec::new() }
    }

    /// Counts the frames, N.
    pub(crate) fn frame_len(&self) -> usize {
        self.vertices.len() / self.vertex_len.max(1)
    }
}
