//! Files become examples: poses and posed meshes of one or of two files, joined and checked.

mod align;
mod error;
mod joined;
mod loaded;
mod matched;
pub mod npz;
mod origins;
mod rate;
mod roots;
mod scene;
mod source;
mod targets;
#[cfg(test)]
mod tests;

pub use error::ImportError;
pub use joined::join;
pub use loaded::Loaded;
pub use source::{Source, load, load_poses};
