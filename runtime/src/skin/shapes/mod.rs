//! Shapes of a skin: how far each moves the vertices, and how it tilts the surface there (METHOD §5).

mod blocks;
mod bounds;
pub(super) mod check;
mod job;
mod view;

pub use job::ShapesJob;
