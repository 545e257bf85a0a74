//! File formats: readers that return plain structs, and the errors of each format.
//!
//! Nothing here knows of examples; [`examples`](crate::examples) joins their results. The baked file belongs
//! to [`sinew_runtime::format`].
//!
//! A new format takes these steps:
//! 1. Add a file or folder here. Its `read` turns a path into one of the structs that other formats share: a
//!    `SampledScene` (a character, its joints and clips), `PosedMeshes`, a [`Mesh`], or a [`ShapedMesh`] (a face and
//!    its shapes). The reader checks everything that the file claims, so that no bytes make it panic. A test spoils
//!    files.
//! 2. Add an error that says what to export instead. A scene extends [`SceneError`]; a new kind of file gets an enum
//!    and a variant of [`FormatError`]. A [`FormatWarning`] reports data that the reader leaves out.
//! 3. Add the file ending where the reader is chosen, and in the message there: for scenes in
//!    `examples/import/source.rs`, for posed meshes in `examples/import/targets.rs`.
//! 4. If the format has materials, read them in [`appearance::load`].
//! 5. Add the file ending to the help of `sinew train` (`cli/input.rs`) and to TRAIN.md.

pub(crate) mod abc;
pub mod appearance;
pub(crate) mod csv;
mod error;
pub(crate) mod extension;
pub(crate) mod fbx;
pub(crate) mod gltf;
pub(crate) mod json;
pub(crate) mod layered;
mod mesh;
pub(crate) mod npz;
pub mod obj;
pub(crate) mod pixels;
mod polygons;
pub(crate) mod posed_meshes;
pub(crate) mod scene;
#[cfg(test)]
pub(crate) mod testing;

pub use abc::AlembicError;
pub use csv::CsvError;
pub use error::{FileError, FormatError, FormatWarning};
pub use extension::Content;
pub use gltf::write::GlbError;
pub use json::JsonError;
pub use layered::LayeredError;
pub use mesh::{Mesh, MeshFile, NamedShape, ShapedMesh};
pub use npz::ArrayError;
pub use posed_meshes::{PointCacheError, SequenceError, save_pc2};
pub use scene::SceneError;
