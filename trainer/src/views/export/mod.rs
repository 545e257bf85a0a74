//! What a model shows at a grid of parameters, or along a path, for other tools: an Inochi2D puppet, Spine JSON, and binary
//! glTF with morph targets (METHOD §6.8).

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
