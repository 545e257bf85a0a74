//! Example poses of one character: what files become and every fit reads.
//!
//! Which frames train: an `.npz` may say it (`import/npz/fields.rs`), else all do, until `hold_out` sets
//! some aside. Folds of a cross-validation are cut in `envelope/folds`.

mod convert;
mod data;
pub mod demo;
mod engine;
mod error;
mod frame_name;
mod hash;
mod hold_out;
mod idle;
mod import;
mod importance;
mod mark;
mod origins;
mod repeat;
mod rigidity;
mod sample;
#[cfg(test)]
pub(crate) mod testing;
mod validate;
mod warning;

pub use crate::formats::scene::JointNames;
pub use crate::formats::scene::{Clip, RATES};
pub use data::{Examples, Matrix3x4, Skeleton, Split};
pub(crate) use error::called;
pub use error::{Element, ExamplesError, LoadError};
pub use frame_name::FrameName;
pub use hash::hash_file;
pub use import::{ImportError, Loaded, Source, join, load, load_motion, load_poses, npz};
pub(crate) use import::{PosedClips, is_shuffled};
pub use importance::{Importance, load_importance};
pub use mark::{Mark, is_same};
pub use rigidity::Distortion;
pub(crate) use sample::spread;
pub use validate::RIGID;
pub use warning::{Severity, Warning};
