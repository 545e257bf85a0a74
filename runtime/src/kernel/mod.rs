//! Kernel maps: weighted sums of functions of the distance from centres (METHOD §2). What a further kernel
//! takes is listed in the trainer's `kernel/mod.rs`.

mod function;
mod map;

pub use function::Kernel;
pub(crate) use map::{Map, Shape, padded};
