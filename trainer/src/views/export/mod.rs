//! Models for other tools (METHOD §6.8).
//!
//! A grid of parameters becomes an Inochi2D puppet, or binary glTF with morph targets. Paths become Spine JSON.

mod error;
mod fade;
mod grid;
mod hull;
mod inp;
mod puppet;
mod scene;
mod sheet;
mod shown;
mod spine;

pub use error::GridError;
pub use grid::{Grid, Node, Side};
pub use puppet::puppet;
pub use scene::glb;
pub use spine::{Spine, spine};
