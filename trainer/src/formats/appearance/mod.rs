//! Appearance of a scene's meshes: names, materials and images, as glTF states them. Exports write it back.

mod arrays;
mod materials;

pub use materials::{Appearance, Image};
pub(crate) use materials::{image_kind, missing_image};

use super::extension::extension;
use super::{fbx, gltf};
use crate::Error;
use std::path::Path;

/// Reads the appearance of a scene's meshes (`.glb`, `.gltf`, `.fbx`) or of arrays (`.npz`). Triangles are in the order of the scene's
/// reader. Files of other formats give an empty appearance.
///
/// # Errors
/// The error names the file: the file cannot be read or is damaged. An image that cannot be read is no error; it is
/// listed in [`Appearance::missing`].
pub fn load(path: &Path) -> Result<Appearance, Error> {
    let read = match extension(path).as_str() {
        "glb" | "gltf" => gltf::rigged::read_appearance(path),
        "fbx" => fbx::appearance::read(path),
        "npz" => arrays::read(path),
        _ => Ok(Appearance::default()),
    };
    read.map_err(|error| error.in_file(path))
}
