//! How well the training poses predict each other, and which meshes do not belong to their poses.

mod broken;
mod moved;
mod region;
mod sound;

pub use broken::{Broken, broken};
pub use moved::{Stand, stands};
pub use region::{HOPS, Region, compared, regions};
pub use sound::{Doubted, Sound};
