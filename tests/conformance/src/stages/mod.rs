//! One body a stage, for any backend: all poses of a subject go through the stage as one batch, on
//! inputs that the CPU has made, and each is compared with the CPU's and with the oracle's.
//! The bounds stand in `tolerance/`, by the same names; `tests/stages/main.rs` runs the bodies.

mod bodies;
pub mod bounds;
pub mod confidence;
pub mod correction;
pub mod features;
pub mod filter;
pub mod gradients;
pub mod joints;
pub mod kernel;
pub mod layout;
pub mod palette;
pub mod shapes;
pub mod skin;
mod transforms;
pub mod whole;

pub use bodies::{Body, applies, body};
pub use transforms::exact;
