//! Puts a model and its clips into an artist's file.
//!
//! The model's meshes get joints and weights. The file's skeleton gets keys, and proxies as children of its joints.
//! Nothing else in the file changes.

mod find;
mod graft;
mod joints;

pub use graft::{ExportInto, Grafted};
