//! Kernel maps: weighted sums of functions of the distance from centres (METHOD §2).

mod function;
mod map;

pub use function::Kernel;
pub(crate) use map::{Map, Shape, padded};
