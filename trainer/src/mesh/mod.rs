//! A mesh at rest: the vertices that a fit moves, those that an engine draws, and their directions.
//!
//! A fit's vertex is a point of the surface. What an artist authors by face corner (texture coordinates, normals,
//! tangents) may differ among the corners of one point; an engine then has as many vertices there.

mod corners;
mod engine;
mod mikktspace;
mod normals;
mod surface;

pub use corners::Corners;
pub use engine::EngineMesh;
pub(crate) use normals::{normals, same_normal};
pub use surface::Surface;
