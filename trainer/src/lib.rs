//! Learns how a character's skin moves from examples, and bakes what it learned into a model for
//! [`sinew_runtime`].
//!
//! The way through: [`examples`] are loaded, an [`envelope`] is fitted to them, [`bake`] writes the
//! file, [`evaluate`] measures that file with the runtime, and [`report`] shows where the error is.
#![forbid(unsafe_code)]

pub mod bake;
pub mod demo;
pub mod envelope;
pub mod evaluate;
pub mod examples;
pub mod files;
pub mod kernel;
pub mod progress;
pub mod report;
