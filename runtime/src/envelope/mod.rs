//! Enveloping: from a pose to a palette of transforms (METHOD §1.8).
//!
//! [`Envelope::palette`] composes the stages of its predictor, which [`crate::stages`] has one by one:
//!
//! | predictor | base of the palette | correction | confidence |
//! |---|---|---|---|
//! | rotational | `gradients`, `palette` | none | `confidence` |
//! | kernel | `joints` | `features`, `correction` | of the correction |
//! | hybrid | `gradients`, `palette` | `features`, `correction` | of the correction |
//!
//! A [`crate::Skin`] takes the palette of any of them.

pub(crate) mod check;
pub(crate) mod confidence;
pub(crate) mod correction;
mod counts;
mod evaluate;
pub(crate) mod features;
pub(crate) mod gradients;
mod group;
mod group_kernel;
mod group_map;
mod group_row;
pub(crate) mod joints;
mod key;
mod local;
pub(crate) mod palette;
mod scratch;
mod view;

pub(crate) use counts::RULES;
pub use counts::{
    BIND_TOLERANCE, Certificate, ENVELOPE_SECTIONS, EnvelopeCounts, KEY_WORDS, NO_JOINT, Predictor,
    TWIST_MAX,
};
pub use group::Group;
pub use group_kernel::GroupKernel;
pub use group_row::GroupRow;
pub use key::Key;
pub use local::{LocalTransform, model_space_pose};
pub use scratch::{ScratchLayout, scratch_len};
pub use view::{Envelope, EnvelopeLayout};
