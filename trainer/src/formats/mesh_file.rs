//! A mesh by itself, from whichever format.

use super::error::FileError;
use super::extension::{extension, unknown_format};
use super::mesh::MeshFile;
use super::{content, fbx, gltf, obj};
use std::path::Path;

impl MeshFile {
    /// Reads a mesh from a `.obj`, `.glb`, `.gltf` or `.fbx` file. Of a scene, meshes with a skin stand as they are bound;
    /// where none has one, all stand as their nodes do.
    ///
    /// # Errors
    /// [`FileError`]: the file cannot be read, or holds no triangles.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let blame = |error| FileError { file: path.to_owned(), error };
        content::check(path).map_err(blame)?;
        match extension(path).as_str() {
            "obj" => Ok(Self { mesh: obj::load(path)?, space: None, warnings: Vec::new() }),
            "glb" | "gltf" => gltf::read_mesh(path).map_err(blame),
            "fbx" => fbx::read_mesh(path).map_err(blame),
            _ => Err(blame(unknown_format(path, ".obj, .glb, .gltf or .fbx"))),
        }
    }
}
