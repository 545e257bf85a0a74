//! Enveloping: from a pose to a palette of transforms (METHOD §1.8).
//!
//! [`Envelope::palette`] composes the stages of its predictor, which [`crate::stages`] has one by one:
//!
//! | predictor | base of the palette | correction | confidence |
//! |---|---|---|---|
//! | rotational | `gradients`, `palette` | none | `confidence` |
//! | kernel | `joints` | `features`, `correction` | of the correction, and of the joints' ranges |
//!
//! A [`crate::Skin`] takes the palette of any of them.

mod bind;
pub(crate) mod check;
pub(crate) mod confidence;
pub(crate) mod correction;
mod counts;
mod evaluate;
pub(crate) mod features;
mod gather;
pub(crate) mod gradients;
mod group;
mod group_kernel;
mod group_map;
mod group_row;
pub(crate) mod joints;
mod key;
mod level;
mod local;
pub(crate) mod palette;
mod pose_check;
mod pose_fault;
mod pose_limits;
mod pose_mistake;
mod pose_space;
mod rest;
mod scratch;
mod skeleton;
mod trust;
mod view;

pub use bind::{BoundJoints, FOLDED};
pub(crate) use counts::RULES;
pub use counts::{
    BIND_TOLERANCE, Certificate, ENVELOPE_SECTIONS, EnvelopeCounts, KEY_WORDS, NO_JOINT, Predictor,
    TWIST_MAX,
};
pub use gather::gather_pose;
pub use group::Group;
pub use group_kernel::GroupKernel;
pub use group_row::GroupRow;
pub use key::Key;
pub use level::Level;
pub use local::{LocalTransform, model_space_pose, model_space_pose_under};
pub use pose_fault::{PoseFault, PoseFaultKind};
pub use pose_limits::{GAP_MARGIN, GAP_TOLERANCE, RIGID_TOLERANCE};
pub use scratch::{ScratchLayout, scratch_len};
pub use skeleton::skeleton_hash_of;
pub use trust::{Evidence, Trust};
pub use view::{Envelope, EnvelopeLayout};
