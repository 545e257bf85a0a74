//! Posed meshes of one character: point caches, and sequences of meshes.

mod cache;
pub(crate) mod sequence;
#[cfg(test)]
mod tests;

pub use cache::save_pc2;
pub(crate) use cache::{read_mdd, read_pc2};

use std::ops::Range;

/// Posed meshes of one character.
#[derive(Clone, Debug, PartialEq)]
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
        let (rest, triangles, reference) = (None, None, None);
        Self { vertex_len, vertices, rest, triangles, reference, parts: Vec::new() }
    }

    /// Counts the frames, N.
    pub(crate) fn frame_len(&self) -> usize {
        self.vertices.len() / self.vertex_len.max(1)
    }
}

/// Reasons why a point cache cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PointCacheError {
    /// The file does not begin as a point cache.
    #[error("is no PointCache2 file of version 1: {reason}; export it as .pc2 again")]
    NotPointCache {
        /// The difference.
        reason: String,
    },
    /// A count in the header is not positive.
    #[error("counts {found} {what}, expected 1 at least; export the point cache again")]
    Count {
        /// `points` or `frames`.
        what: &'static str,
        /// The count.
        found: i32,
    },
    /// The counts in the header ask for more bytes than a file can have.
    #[error(
        "counts {points} points in {frames} frames, more than a file can hold; export the point cache again"
    )]
    TooMany {
        /// Points in a frame.
        points: u64,
        /// Number of frames.
        frames: u64,
    },
    /// The file is too short or too long for its header.
    #[error(
        "should have {expected} bytes by its header, found {found}; export the point cache again"
    )]
    Length {
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes of the file.
        found: u64,
    },
}

/// Reasons why OBJ files do not form a sequence.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// The folder has no OBJ file.
    #[error(
        "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, pose_2.obj"
    )]
    NoObj,
    /// The name of an OBJ file has no frame number.
    #[error("has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj")]
    NoNumber,
    /// Two OBJ files have the same number, so that their order is not known.
    #[error(
        "has the frame number of {other}, {number}; keep one of them, or one sequence a folder"
    )]
    SameNumber {
        /// The number.
        number: u64,
        /// Name of the other file.
        other: String,
    },
    /// The meshes of a sequence have different vertices.
    #[error(
        "has {found} vertices, expected {expected} as in {first}; export every frame with the same \
         vertices in the same order"
    )]
    OtherVertices {
        /// Vertices in the file.
        found: usize,
        /// Vertices in the first file.
        expected: usize,
        /// Name of the first file.
        first: String,
    },
    /// The meshes of a sequence have different faces.
    #[error(
        "has other faces than {first}, from face {face} on ({found_len} in all, expected \
         {expected_len}); export every frame with the same faces, not triangulated anew"
    )]
    OtherFaces {
        /// Name of the first file.
        first: String,
        /// First face that differs, counted from 1.
        face: usize,
        /// Faces in the file.
        found_len: usize,
        /// Faces in the first file.
        expected_len: usize,
    },
}
