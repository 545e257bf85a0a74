//! FBX: skinned meshes, or a mesh beside a skeleton, and their animations.
//!
//! Units and axes stay as they are in the file. Vertices are its control points, in their order; the
//! meshes of several nodes follow one another in the order of the nodes.

pub(super) mod appearance;
mod blends;
mod convert;
mod corners;
mod frames;
mod joints;
mod meshes;
mod motion;
mod read;
mod shaped;
#[cfg(test)]
mod tests;

pub(crate) use motion::read_motion;
pub(crate) use read::read;
pub(super) use read::read_mesh;
pub(crate) use shaped::read_shapes;
