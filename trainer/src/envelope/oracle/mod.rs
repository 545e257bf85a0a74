//! The f64 oracle of the runtime's stages: METHOD §1.1 to §1.9 on a model, as fitted or as a file
//! holds it.
//!
//! It evaluates with general matrix routines and shares no code with the runtime's stages, so that
//! each can be tested against it, alone or from pose to skin.

mod correction;
mod evaluate;
mod reconstruction;
mod shapes;
mod skin;

pub use reconstruction::stack;
pub use shapes::ShapedVertex;
pub use skin::SkinnedVertex;
