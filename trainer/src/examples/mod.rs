//! Example poses of one character: importers create them, and every fit reads them.
//!
//! The `split` array of an `.npz` chooses the training frames (`import/npz/fields.rs`). Without the array every frame
//! trains. [`Examples::hold_out`] replaces the split. Cross-validation folds are in `envelope/folds`.

mod curves;
mod data;
pub mod demo;
mod distortion;
mod fingerprint;
mod frames;
mod import;
mod importance;
mod joints;
mod poses;
#[cfg(test)]
pub(crate) mod testing;
mod validate;
mod warning;

pub use crate::formats::scene::{Clip, JointNames, RATES};
pub use curves::Curves;
pub use data::{Examples, Matrix3x4, Skeleton, Split};
pub(crate) use data::{diagonal, spread};
pub use distortion::{Distortion, RIGID};
pub use fingerprint::{Mark, hash_file, is_same};
pub use frames::{FrameName, check_share, numbered};
pub use import::{Loaded, Source, has_no_mesh, join, load, load_motion, load_poses, npz};
pub(crate) use import::{best_order, is_shuffled};
pub use importance::{Importance, load_importance};
pub use poses::save::save_poses;
pub use poses::{PoseRequest, SampledPoses, sample_poses};
pub use warning::{Severity, Warning};
