//! A mesh at rest: the vertices that a fit moves, the vertices that an engine draws, and their directions.
//!
//! A fit's vertex is a point of the surface. An artist authors texture coordinates, normals and tangents by face
//! corner. They may differ among the corners of one point; an engine then has several vertices there.

mod corners;
mod surface;

pub use corners::Corners;
pub use surface::{EngineMesh, Surface};
pub(crate) use surface::{normals, same_normal};
