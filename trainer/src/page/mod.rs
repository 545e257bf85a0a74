//! What every report is made of: the page itself, charts, colours, and pictures of meshes. Nothing
//! here knows what is reported.

pub(crate) mod bars;
pub mod camera;
pub(crate) mod chart;
pub mod colour;
pub mod drawing;
pub mod gif;
pub(crate) mod html;
pub mod picture;
pub mod render;
