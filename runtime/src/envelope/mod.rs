//! Envelopes: from a pose to a palette of transforms (METHOD §1.8).
//!
//! [`Envelope::palette`] runs the stages of the envelope's predictor. With the feature `internals`, `stages` has each stage as a function.
//!
//! | predictor | base of the palette | correction | confidence |
//! |---|---|---|---|
//! | rotational | `gradients`, `palette` | none | `confidence` |
//! | kernel | `joints` | `features`, `correction` | `correction`, from the kernel maps and the ranges |
//!
//! If joints stretch, stage `polar` comes first: it splits each joint's transform into a rotation and a strain.
//!
//! A [`crate::Skin`] takes the palette of either predictor.

pub(crate) mod check;
pub(crate) mod confidence;
mod counts;
mod evaluate;
mod group;
pub(crate) mod helpers;
pub(crate) mod polar;
pub(crate) mod pose;
pub(crate) mod rotational;
mod scratch;
#[cfg(feature = "trs")]
pub(crate) mod trs;
mod view;

pub(crate) use counts::RULES;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use counts::{
    BIND_TOLERANCE, ENVELOPE_SECTIONS, EnvelopeCounts, KEY_WORDS, NO_JOINT, STRAIN_LEN, TWIST_MAX,
};
pub use counts::{Certificate, HelperKind, Predictor};
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use group::{Group, GroupConfidence, GroupKernel, GroupRow};
pub use pose::{
    BoundJoints, FOLDED, LocalTransform, PoseFault, PoseFaultKind, gather_pose, model_space_pose,
    model_space_pose_under, skeleton_hash_of,
};
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use pose::{CURVE_MARGIN, GAP_MARGIN, GAP_TOLERANCE, RIGID_TOLERANCE, STRETCH_MARGIN};
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use scratch::{ScratchLayout, scratch_len};
#[cfg(feature = "trs")]
pub use trs::Trs;
pub use view::Envelope;
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) use view::Key;
