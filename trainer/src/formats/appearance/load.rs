//! The appearance of a file's meshes, by its format.

use std::path::Path;

use super::data::Appearance;
use crate::formats::error::FileError;
use crate::formats::extension::extension;
use crate::formats::{fbx, gltf};

/// Reads what the meshes of a scene look like (`.glb`, `.gltf`, `.fbx`), for the triangles in the order in
/// which its reader gives them; nothing is known of other files.
///
/// # Errors
/// A [`FileError`] that names the file, which cannot be read or is damaged. An image that cannot be read
/// is no error, but listed.
pub fn load(path: &Path) -> Result<Appearance, FileError> {
    let read = match extension(path).as_str() {
        "glb" | "gltf" => gltf::appearance::read(path),
        "fbx" => fbx::appearance::read(path),
        _ => Ok(Appearance::default()),
    };
    read.map_err(|error| FileError { file: path.to_owned(), error })
}
