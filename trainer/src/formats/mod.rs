//! Formats of files: what a file holds, as plain structs, and what can be wrong with it. Nothing here
//! knows of examples; [`examples`](crate::examples) joins what is read here. The baked file is no affair
//! of this folder: that is [`sinew_runtime::format`].
//!
//! A new format takes these steps:
//! 1. A file or folder of its own here, whose `read` makes of a path one of the structs that other
//!    formats make too: a `SampledScene` (a character, its joints and clips), `PosedMeshes`, a [`Mesh`], a
//!    [`ShapedMesh`] (a face and its shapes).
//!    It checks all that the file says of itself, so that no bytes make it panic, and has a test that
//!    spoils them.
//! 2. An error that says what to export instead. A scene adds to [`SceneError`]; what is new has an
//!    enum of its own, a variant of [`FormatError`]. What is left out is a [`FormatWarning`].
//! 3. Its ending, where the reader is chosen by it and in the message beside: of scenes
//!    `examples/import/source.rs`, of posed meshes `examples/import/targets.rs`.
//! 4. What its meshes look like, in `appearance/load.rs`, where it says so.
//! 5. Its ending in the help of `sinew train` (`cli/input.rs`) and in TRAIN.md.

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
