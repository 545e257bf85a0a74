//! Exports models for other tools (METHOD §6.8).
//!
//! A grid of parameters becomes an Inochi2D puppet, or binary glTF with morph targets. Paths become Spine JSON.

mod grid;
mod puppet;
mod scene;
mod sheet;
mod shown;
mod spine;

pub use grid::{Grid, Node, Side};
pub use puppet::puppet;
pub use scene::glb;
pub use spine::{Spine, spine};
