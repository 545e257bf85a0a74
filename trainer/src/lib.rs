//! Learns how a character's skin moves from examples, and bakes what it learned into a model for
//! [`sinew_runtime`].
//!
//! The way through: files are read by their [`formats`] and become [`examples`]; an [`envelope`] is
//! checked, fitted to them and baked into a file by [`bake`]; the runtime measures that file, a report
//! made of [`page`] shows where the error is, and an export hands it to engines. A [`face`] is a skin of its own: its
//! shapes are given, and what a take teaches is how they go together. Samples of a
//! [`signal`] become a filter that makes it finer.
//!
//! **A new part plugs in** with a folder of its own, as [`envelope`] is one: its model in f64, its fit,
//! its `bake` (which makes a [`bake::Part`]: a kind and sections), its evaluation and its report. `cli/command.rs`
//! learns of its commands in one line; a part that stands in one file with an envelope is a field of
//! [`envelope::model::FileModel`], written in `envelope/bake/file.rs` and named in
//! `cli/envelope/inspect.rs`. What the runtime asks for is in the doc of its `format/mod.rs`.
//! [`bake`], [`page`], [`regression`], [`scattered`], [`numeric`], [`mesh`], [`formats`] and [`space`] know no part. The
//! numbers that a fit is set to are in [`settings`].
#![forbid(unsafe_code)]

pub mod bake;
pub mod check;
pub mod envelope;
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
