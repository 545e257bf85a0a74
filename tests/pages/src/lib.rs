//! What the pages for an engine's developer show, run: their code, their figures, their builds.
//!
//! `build.rs` takes the Rust of a page apart, so that a test calls the very lines that a reader copies; the
//! character is the demo's arm, whose skeleton, mesh and poses make sense to look at.

pub mod arm;
pub mod browser;
pub mod build;
pub mod text;
