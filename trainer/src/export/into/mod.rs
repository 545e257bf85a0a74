//! A model and its clips in an artist's own file.
//!
//! The meshes that are the model's take joints and weights, the file's own skeleton takes keys and proxies
//! under its joints; nothing else of the file changes.

mod find;
mod graft;
mod joints;

pub use graft::{ExportInto, Grafted};
