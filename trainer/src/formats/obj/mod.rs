//! Meshes as Wavefront OBJ files.

mod error;
mod read;
#[cfg(test)]
mod tests;

pub use error::ObjError;
pub use read::load;
pub(super) use read::{Parsed, read};
