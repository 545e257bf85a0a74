//! Poses: how a pose is made for an envelope, and which mistakes a wrong pose shows.

mod arrays;
mod check;
mod fault;
mod local;
mod mistake;
mod skeleton;

pub(crate) use arrays::Pose;
pub use fault::{
    CURVE_MARGIN, GAP_MARGIN, GAP_TOLERANCE, PoseFault, PoseFaultKind, RIGID_TOLERANCE,
    STRETCH_MARGIN,
};
pub use local::{LocalTransform, model_space_pose, model_space_pose_under};
pub use skeleton::{BoundJoints, FOLDED, gather_pose, skeleton_hash_of};
