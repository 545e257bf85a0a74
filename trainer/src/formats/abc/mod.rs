//! Alembic, `.abc`: the polygon meshes of an Ogawa archive, posed frame by frame where its transforms put them.
//!
//! Axes and unit stay as they are in the file, which says nothing of them. Vertices are the meshes', in their order;
//! several meshes follow one another in the order of the file.

mod error;
mod header;
mod mesh;
mod objects;
mod ogawa;
mod property;
mod read;
#[cfg(test)]
mod tests;
mod transform;

pub use error::AlembicError;
pub(crate) use read::read;
