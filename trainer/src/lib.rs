//! Learns how a character's skin moves from examples, and bakes what it learned into a model for
//! [`sinew_runtime`].
//!
//! The way through: [`examples`] are loaded, a [`check`] tells what is wrong with them, an
//! [`envelope`] is fitted to them, [`bake`] writes the file, [`evaluate`] measures that file with the
//! runtime, [`report`] shows where the error is, and [`export`] hands it to engines.
#![forbid(unsafe_code)]

mod axes;
pub mod bake;
pub mod envelope;
pub mod examples;
pub mod files;
pub mod kernel;
pub mod numeric;
pub mod page;
pub mod progress;
