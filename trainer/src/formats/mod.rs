//! File formats: readers that return plain structs.
//!
//! Nothing here knows of examples; [`examples`](crate::examples) joins their results. The baked file belongs
//! to [`sinew_runtime::format`].
//!
//! A new format takes these steps:
//! 1. Add a file or folder here. Its `read` turns a path into one of the structs that other formats share: a
//!    `SampledScene` (a character, its joints and clips), `PosedMeshes`, a [`Mesh`], or a [`ShapedMesh`] (a face and
//!    its shapes). The reader checks everything that the file claims, so that no bytes make it panic. A test spoils
//!    files.
//! 2. Return an [`Error`] that says what to export instead. `scene/faults.rs` has those that scenes of several formats
//!    share. A [`FormatWarning`] reports data that the reader leaves out.
//! 3. Add the file ending where the reader is chosen, and in the message there: for scenes in
//!    `examples/import/source.rs`, for posed meshes in `examples/import/targets.rs`.
//! 4. If the format has materials, read them in [`appearance::load`].
//! 5. Add the file ending to the help of `sinew train` (`cli/input.rs`) and to TRAIN.md.

pub(crate) mod abc;
pub mod appearance;
pub(crate) mod csv;
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
pub(crate) mod usd;
mod warning;

pub use extension::Content;
pub use mesh::{Mesh, MeshFile, NamedShape, ShapedMesh};
pub use posed_meshes::cache::save_pc2;
pub use warning::FormatWarning;

use crate::Error;
use extension::{check_content, extension, unknown_format};
use std::path::Path;

impl MeshFile {
    /// Reads a mesh from a `.obj`, `.glb`, `.gltf` or `.fbx` file.
    ///
    /// Meshes of a scene that have a skin are in their bind pose. If no mesh has a skin, all are placed by their nodes.
    ///
    /// # Errors
    /// The error names the file: the file cannot be read, has another ending or content, is damaged, or has no triangles.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let read = || {
            check_content(path)?;
            match extension(path).as_str() {
                "obj" => Ok(Self { mesh: obj::load(path)?, space: None, warnings: Vec::new() }),
                "glb" | "gltf" => gltf::read_mesh(path),
                "fbx" => fbx::read_mesh(path),
                _ => Err(unknown_format(path, ".obj, .glb, .gltf or .fbx")),
            }
        };
        read().map_err(|error: Error| error.in_file(path))
    }
}
