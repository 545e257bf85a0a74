//! A model and its clips in an artist's own file.
//!
//! The meshes that are the model's take joints and weights, the file's own skeleton takes keys and proxies
//! under its joints; nothing else of the file changes.

pub(super) mod error;
mod find;
mod graft;
mod joints;
mod unused;

pub use error::IntoError;
pub use graft::{ExportInto, Grafted};
