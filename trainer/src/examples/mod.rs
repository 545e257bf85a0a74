//! Example poses of one character: what every importer produces and every fit reads.

mod clip;
mod data;
mod error;
mod extension;
mod fbx;
mod gltf;
mod hash;
mod hold_out;
mod importance;
mod loaded;
mod maps;
mod mesh;
pub mod npz;
pub mod obj;
mod origins;
mod polygons;
mod rig;
mod roots;
mod sample;
mod source;
mod space;
mod surface;
mod targets;
#[cfg(test)]
mod testing;
mod validate;

pub use clip::Clip;
pub use data::{Examples, Matrix3x4, Skeleton, Split};
pub use error::{Element, ExamplesError, LoadError, Warning};
pub use hash::hash_file;
pub use importance::{Importance, load_importance};
pub use loaded::Loaded;
pub use mesh::Mesh;
pub use rig::ImportError;
pub(crate) use sample::spread;
pub use source::{Source, load, load_poses};
pub(crate) use space::direction;
pub use space::{Conversion, SpaceError, SpaceWish};
pub(crate) use surface::{normals, tangents};
pub use targets::{TargetsError, save_pc2};
pub use validate::RIGID;
