//! Posed meshes by the formats of their files.

use super::data::Targets;
use super::{mdd, obj, pc2};
use crate::examples::extension::{extension, unknown_format};
use crate::examples::{ExamplesError, LoadError, gltf, npz};
use std::path::{Path, PathBuf};

/// Reads posed meshes: a point cache (`.pc2`, `.mdd`), arrays (`.npz`), one of a sequence of numbered
/// `.obj` files, a folder that holds one, or a scene's own shapes (`.glb`, `.gltf`).
///
/// # Errors
/// A [`LoadError`] that names the file at fault: it cannot be read, is none of these or is damaged;
/// or it does not have the vertices and faces of the first of its sequence.
pub(in crate::examples) fn read(path: &Path) -> Result<Targets, LoadError> {
    if path.is_dir() {
        return obj::read(path);
    }
    let blame = |error| LoadError { file: path.to_owned(), error };
    let bytes = || std::fs::read(path).map_err(|error| blame(ExamplesError::Read(error)));
    match extension(path).as_str() {
        "obj" => obj::read(path),
        "npz" => npz::read_targets(path).map_err(blame),
        "pc2" => pc2::parse(&bytes()?).map_err(|error| blame(error.into())),
        "mdd" => mdd::parse(&bytes()?).map_err(|error| blame(error.into())),
        "glb" | "gltf" => gltf::read_targets(path).map_err(blame),
        _ => Err(blame(unknown_format(path, ".pc2, .mdd, .npz, .glb, .gltf or .obj"))),
    }
}

/// Lists the files that [`read`] reads; the path itself where it would fail.
pub(in crate::examples) fn files(path: &Path) -> Vec<PathBuf> {
    let sequence = path.is_dir() || extension(path) == "obj";
    let files = sequence.then(|| obj::sequence(path).ok()).flatten();
    files.unwrap_or_else(|| vec![path.to_owned()])
}
