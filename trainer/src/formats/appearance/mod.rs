//! What the meshes of a scene look like: beside what moves them, for who writes them again.

pub(in crate::formats) mod data;
pub(crate) mod image;
mod load;

pub use data::{Appearance, Image};
pub use load::load;
