//! Where a face comes from: one way in for every format.

use super::basis::{Basis, ExampleMeshes};
use super::error::FaceError;
use super::{meshes, npz};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::obj::read_folder;
use crate::formats::{fbx, gltf};
use std::path::Path;

/// What a file gives to make a face of.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A neutral mesh and named shapes.
    Shapes(Basis),
    /// Meshes, of which shapes are still to be found.
    Meshes(ExampleMeshes),
}

/// Reads a face: a `.npz`, a scene with morph targets (`.glb`, `.gltf`, `.fbx`), or a folder of OBJ files.
///
/// # Errors
/// [`FaceError::Format`], [`FaceError::File`], and what the arrays of a `.npz` lack; [`FaceError::NoShapes`],
/// [`FaceError::Twice`] and [`FaceError::NotFinite`] of any.
pub fn read(path: &Path) -> Result<Source, FaceError> {
    if path.is_dir() {
        return Basis::of(read_folder(path)?).check().map(Source::Shapes);
    }
    let mesh = match extension(path).as_str() {
        "npz" if npz::has_shapes(path)? => return npz::read(path)?.check().map(Source::Shapes),
        "npz" => return meshes::read(path).map(Source::Meshes),
        "glb" | "gltf" => gltf::read_shapes(path)?,
        "fbx" => fbx::read_shapes(path)?,
        _ => return Err(unknown_format(path, ".npz, .glb, .gltf or .fbx, or a folder").into()),
    };
    Basis::of(mesh).check().map(Source::Shapes)
}
