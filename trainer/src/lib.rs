//! Learns how a character's skin moves from examples, and bakes the result into a model for [`sinew_runtime`].
//!
//! **The path of data.** [`formats`] read files, which become [`examples`]. An [`envelope`] is checked, fitted to the
//! examples and baked into a file by [`bake`]. The runtime evaluates that file to measure it. A report made with
//! [`page`] shows where the error is, and an export hands the model to engines. A [`face`] is a separate kind of skin:
//! its shapes are given, and a take shows their combinations. Samples of a [`signal`] become a filter that refines it.
//!
//! **A new part** gets a folder, as [`envelope`] has: its model in f64, its fit, its `bake` (which makes a
//! [`bake::Part`]: a kind and sections), its evaluation and its report. `cli/mod.rs` lists its commands in one
//! line. A part that shares a file with an envelope is a field of [`envelope::model::FileModel`]; it is written in
//! `envelope/bake/file.rs` and printed in `cli/inspect.rs`. The doc of the runtime's `format/mod.rs` says
//! which files the runtime accepts. [`bake`], [`page`], [`regression`], [`scattered`], [`numeric`], [`mesh`], [`formats`] and
//! [`space`] know no part. The numbers that set a fit are in [`settings`].
#![forbid(unsafe_code)]

pub mod bake;
pub mod check;
#[doc(hidden)]
pub mod cli;
pub mod envelope;
mod error;
pub mod evaluate;
pub mod examples;
pub mod export;
pub mod face;
pub mod files;
pub mod formats;
pub mod mesh;
pub mod numeric;
pub mod page;
pub mod progress;
pub mod regression;
pub mod report;
pub mod scattered;
pub mod settings;
pub mod signal;
pub mod space;
pub mod views;

pub use error::{Error, ErrorKind};
