//! Posed meshes of one character: point caches, and sequences of meshes.
//! Posed meshes.
//! What can be wrong with posed meshes.

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

/// A point cache that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PointCacheError {
    /// The file does not begin as one.
    #[error("is no PointCache2 file of version 1: {reason}; export it as .pc2 again")]
    NotPointCache {
        /// What is different.
        reason: String,
    },
    /// A count in the header is not positive.
    #[error("counts {found} {what}, expected 1 at least; export the point cache again")]
    Count {
        /// What is counted.
        what: &'static str,
        /// The count.
        found: i32,
    },
    /// The counts in the header ask for more bytes than a file can have.
    #[error(
        "counts {points} points in {frames} frames, more than a file can hold; export the point cache again"
    )]
    TooMany {
        /// Points of a frame.
        points: u64,
        /// Frames.
        frames: u64,
    },
    /// The file is cut off, or goes on after its end.
    #[error(
        "should have {expected} bytes by its header, found {found}; export the point cache again"
    )]
    Length {
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
}

/// Numbered OBJ files that are no sequence.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// A folder has no OBJ file.
    #[error(
        "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, pose_2.obj"
    )]
    NoObj,
    /// An OBJ file has no number, so that its frame is not known.
    #[error("has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj")]
    NoNumber,
    /// Two OBJ files have one number, so that their order is not known.
    #[error(
        "has the frame number of {other}, {number}; keep one of them, or one sequence a folder"
    )]
    SameNumber {
        /// The number.
        number: u64,
        /// The other file's name.
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
        /// The first file's name.
        first: String,
    },
    /// The meshes of a sequence have different faces.
    #[error(
        "has other faces than {first}, from face {face} on ({found_len} in all, expected \
         {expected_len}); export every frame with the same faces, not triangulated anew"
    )]
    OtherFaces {
        /// The first file's name.
        first: String,
        /// The first face that differs, the first of all being 1.
        face: usize,
        /// Faces in the file.
        found_len: usize,
        /// Faces in the first file.
        expected_len: usize,
    },
}
