//! Evaluates baked Sinew models: no standard library, no allocation, and the same bits on every CPU.
//!
//! [`Model::from_bytes`] checks a file once; after that every evaluation reads it in place and can
//! fail only for the caller's own arguments. The file is described in `FORMAT.md`.
//!
//! "METHOD" in these pages is the trainer's `METHOD.md`: the mathematics, with its sources.
//!
//! Arithmetic is plain IEEE single precision: no fused multiply-add, one fixed order of summation,
//! and one polynomial for each transcendental function (METHOD §7).
#![no_std]
#![forbid(unsafe_code)]

pub mod envelope;
mod error;
#[cfg(feature = "filter")]
pub mod filter;
pub mod format;
#[cfg(feature = "kernel")]
pub mod kernel;

mod lanes;
mod limits;
mod linear;
mod model;
mod names;
mod numeric;
#[cfg(feature = "prior")]
pub mod prior;
#[cfg(feature = "record")]
pub mod record;
pub mod skin;
pub mod stages;
#[cfg(feature = "views")]
pub mod views;
mod workspace;

pub use envelope::{Envelope, LocalTransform, model_space_pose};
pub use error::{Argument, CallError, CallErrorKind};
#[cfg(feature = "filter")]
pub use filter::Filter;
pub use format::{FileError, FileErrorKind};
#[cfg(feature = "kernel")]
pub use kernel::KernelMap;
pub use limits::Limits;
pub use linear::Matrix3x4;
pub use model::{Model, Section};
#[cfg(feature = "prior")]
pub use prior::{Pin, PinJob, Pins, Prior};
#[cfg(feature = "record")]
pub use record::Record;
#[cfg(feature = "shapes")]
pub use skin::ShapesJob;
pub use skin::{Skin, SkinJob};
#[cfg(feature = "views")]
pub use views::{Frame, FrameJob, RenderJob, Views};
pub use workspace::Workspace;

/// The example of `README.md`, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
