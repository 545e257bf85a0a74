//! Rigged characters from scene files, and how they become examples.

mod align;
mod character;
mod error;
mod sampling;
#[cfg(test)]
mod tests;
mod times;

pub(super) use character::Rig;
pub use error::ImportError;
pub(super) use sampling::Sampling;
pub(super) use times::sample_times;
