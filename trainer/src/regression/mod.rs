//! Regression of functions that vanish at rest: how a correction depends on the pose (METHOD §1.6).
//!
//! [`inputs`] measures distances between samples and chooses kernel centres. [`design`] decomposes the part of the
//! problem that depends on inputs alone. [`ridge`] fits [`outputs`] to a design, and [`map`] evaluates the fit.
//! [`gram`] replaces outputs by their inner products where only errors are needed. [`outputs`] also computes,
//! in closed form, the errors of samples that a fit leaves out.
//!
//! [`function`] holds the kernels, [`rotations`] the features of a rotation, [`arithmetic`] the rounding model.
//! [`confidence`] lowers a correction where the pose is far from the samples.

pub mod arithmetic;
pub mod confidence;
pub mod design;
pub mod function;
pub mod gram;
pub mod inputs;
pub mod map;
pub mod outputs;
pub mod ridge;
pub mod rotations;
