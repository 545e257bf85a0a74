//! Poses: how a pose is made for an envelope, and which mistakes a wrong pose shows.

mod check;
mod fault;
mod local;
mod mistake;
mod skeleton;

pub use fault::{GAP_MARGIN, GAP_TOLERANCE, PoseFault, PoseFaultKind, RIGID_TOLERANCE};
pub use local::{LocalTransform, model_space_pose, model_space_pose_under};
pub use skeleton::{BoundJoints, FOLDED, gather_pose, skeleton_hash_of};
