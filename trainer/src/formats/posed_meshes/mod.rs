//! Posed meshes of one character: point caches, and sequences of meshes.

mod data;
mod error;
pub(crate) mod mdd;
pub(crate) mod pc2;
mod points;
pub(crate) mod sequence;
#[cfg(test)]
mod tests;

pub(crate) use data::{Part, PosedMeshes};
pub use error::{PointCacheError, SequenceError};
