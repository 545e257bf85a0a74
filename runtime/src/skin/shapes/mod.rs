//! Shapes of a skin: offsets of vertices, and slopes of the surface (METHOD §5).

mod blocks;
pub(super) mod check;
mod job;
mod view;

pub use job::ShapesJob;
