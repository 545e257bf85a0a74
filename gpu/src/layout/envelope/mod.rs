//! Batches of an envelope, and of a skin that follows it.

mod batch;
mod check;
mod demand;

pub use batch::{Batch, Rest, SkinBatch};
pub(super) use demand::demand;
