//! The f64 oracle of the runtime's stages: METHOD §1.1 to §1.9 on the numbers that a file holds.
//!
//! It reads a loaded file's rounded arrays and evaluates them in double precision with general
//! matrix routines. It shares no code with the runtime's stages, so that each can be tested against
//! it, alone or from pose to skin.

mod correction;
mod group;
mod maps;
mod model;

pub use group::Group;
pub use maps::{after, cofactors, linear, seen_from, stack, symmetric};
pub use model::{Factors, Key, Oracle, Skinned, Vertex};
