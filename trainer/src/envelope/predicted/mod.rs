//! How well the training poses predict each other, and which meshes do not belong to their poses.

mod broken;
mod region;
mod sound;

pub use broken::{Broken, broken};
pub use region::{HOPS, Region, compared, regions};
pub use sound::{Doubted, Sound};
