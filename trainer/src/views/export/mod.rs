//! What a model shows at a grid of parameters, for tools that go by grids: an Inochi2D puppet, and binary glTF with morph
//! targets (METHOD §6.8).

mod error;
mod grid;
mod inp;
mod puppet;
mod scene;
mod sources;

pub use error::GridError;
pub use grid::{Grid, Node, Side};
pub use puppet::puppet;
pub use scene::glb;
