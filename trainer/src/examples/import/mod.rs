//! Imports examples: poses and posed meshes from one or two files, joined and checked.

mod align;
mod clips;
mod curves;
mod joined;
mod matched;
mod motion;
pub mod npz;
mod scene;
mod source;
mod targets;
#[cfg(test)]
mod tests;

pub(crate) use align::is_shuffled;
pub(crate) use clips::best_order;
pub use joined::{Loaded, join};
pub use source::{Source, has_no_mesh, load, load_motion, load_poses};
