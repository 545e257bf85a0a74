//! Evaluates baked Sinew models: no standard library, no allocation, and the same bits on every CPU.
//!
//! [`Model::from_bytes`] checks a file once; after that every evaluation reads it in place and can
//! fail only for the caller's own arguments. The file is described in `FORMAT.md`.
//!
//! Arithmetic is plain IEEE single precision: no fused multiply-add, one fixed order of summation,
//! and one polynomial for each transcendental function (METHOD §7).
#![no_std]
#![forbid(unsafe_code)]

pub mod envelope;
mod error;
pub mod format;
pub mod kernel;
mod limits;
mod linear;
mod model;
mod numeric;
pub mod pose;
mod workspace;

pub use envelope::Envelope;
pub use error::{Argument, EvalError, FormatError};
pub use limits::{Limits, Quantity};
pub use model::{Model, Section};
pub use pose::{LocalTransform, model_space_pose};
pub use workspace::Workspace;

/// A rigid or affine map as three rows of four: `y[r] = m[r][0..3] . x + m[r][3]`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// The example of `README.md`, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
