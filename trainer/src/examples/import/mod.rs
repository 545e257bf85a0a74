//! Files become examples: poses and posed meshes of one or of two files, joined and checked.

mod align;
mod chosen;
mod error;
mod joined;
mod loaded;
mod matched;
mod motion;
pub mod npz;
mod order;
mod parts;
mod rate;
mod roots;
mod scene;
mod shuffled;
mod source;
mod targets;
#[cfg(test)]
mod tests;
mod unposed;

pub use error::ImportError;
pub use joined::join;
pub use loaded::Loaded;
pub(crate) use order::PosedClips;
pub(crate) use shuffled::is_shuffled;
pub use source::{Source, load, load_motion, load_poses};
