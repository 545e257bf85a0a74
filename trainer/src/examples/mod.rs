//! Example poses of one character: what every importer produces and every fit reads.

/// A rigid or affine map as three rows of four: `y = m[..][0..3] x + m[..][3]`.
pub type Matrix3x4 = [[f64; 4]; 3];

/// Which use a frame is put to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Read by the fit and by every choice.
    Train,
    /// Read only to report, after every choice is made.
    HeldOut,
    /// Reported apart: poses beyond the range of motion of the training frames.
    Extreme,
}

/// The joints of a character: one reference root, every other joint with one parent.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// J names.
    pub names: Vec<String>,
    /// Parent of each joint; `None` for the reference root alone. Parents may follow children.
    pub parents: Vec<Option<usize>>,
    /// Model-space rest frame of each joint (rigid); its last column is the rest origin.
    pub rest: Vec<Matrix3x4>,
}

/// N poses of one mesh of V vertices and T triangles on J joints, in the units of the input.
#[derive(Clone, Debug)]
pub struct Examples {
    /// Rest positions, V.
    pub rest: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle, T; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// Texture coordinates, one per vertex, where the source has them so.
    pub uv: Option<Vec<[f64; 2]>>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Posed positions, N x V, frame-major.
    pub vertices: Vec<[f64; 3]>,
    /// Map from the rest pose to the pose of each joint, N x J, frame-major, model space.
    pub transforms: Vec<Matrix3x4>,
    /// Use of each frame, N.
    pub split: Vec<Split>,
}
