//! Why a model could not be baked.

use sinew_runtime::FileError;

/// Why a model could not be baked.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum BakeError {
    /// An array does not fit the others.
    #[error("{what}: expected {expected} elements, found {found}")]
    Length {
        /// The array.
        what: &'static str,
        /// What the other arrays imply.
        expected: usize,
        /// What it has.
        found: usize,
    },
    /// A number is too large for its place in the file.
    #[error("{what}: {found} does not fit the file")]
    Size {
        /// What is counted or indexed.
        what: &'static str,
        /// The number.
        found: usize,
    },
    /// A joint cannot be reached from the root by way of parents.
    #[error("joint {joint} does not descend from the root")]
    Hierarchy {
        /// The joint.
        joint: usize,
    },
    /// A rest frame has no inverse.
    #[error("the rest frame of joint {joint} cannot be inverted")]
    RestFrame {
        /// The joint.
        joint: usize,
    },
    /// The weights of a vertex do not have a positive sum.
    #[error("the weights of vertex {vertex} sum to {sum}, expected 1")]
    Weights {
        /// The vertex.
        vertex: usize,
        /// Their sum.
        sum: f64,
    },
    /// The covariance of a prior has no inverse.
    #[error("the covariance of the weights has no inverse")]
    Covariance,
    /// A skin names an envelope that is not there.
    #[error("skin {skin} follows envelope {envelope}, of {found}")]
    NoEnvelope {
        /// The skin's number.
        skin: usize,
        /// The envelope's that it names.
        envelope: usize,
        /// How many there are.
        found: usize,
    },
    /// The runtime refuses what was written.
    #[error("the runtime refuses the baked model: {0}")]
    Refused(FileError),
}
