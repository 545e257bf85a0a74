//! Priors over the weights of shapes: what a take teaches of them, and how a file holds it (METHOD §5.1).

mod bake;
mod learn;
mod model;
mod pairs;

pub use learn::{FLOOR, beta, is_moving, learned, slider};
pub use model::PriorModel;
pub use pairs::{Pairs, pairs};
