//! Meshes as Wavefront OBJ files.

mod error;
mod folder;
mod read;
#[cfg(test)]
mod tests;

pub(crate) mod write;

pub use error::ObjError;
pub(crate) use folder::read_folder;
pub use read::load;
pub(super) use read::{Parsed, read};
