//! The parts of every report: the page, charts, colours, and pictures of meshes. This module knows nothing of the
//! reports.

pub mod camera;
pub(crate) mod chart;
pub mod colour;
pub mod drawing;
pub(crate) mod html;
pub mod picture;
pub mod render;
