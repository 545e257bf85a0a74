//! A folder of OBJ files: a neutral mesh, and one for each shape.

use std::path::{Path, PathBuf};

use super::error::ObjError;
use super::read::{Parsed, read};
use crate::formats::error::{FileError, FormatError};
use crate::formats::extension::extension;
use crate::formats::shaped::{NamedShape, ShapedMesh};

/// What the neutral mesh is called.
const NEUTRAL: &str = "neutral";

/// Reads `neutral.obj` and every other OBJ beside it, the shapes called as their files and in the order of those
/// names.
///
/// # Errors
/// A [`FileError`] that names the file: it cannot be read, has faces of nothing, or has not as many vertices as
/// the neutral one; of the folder, that it has no neutral mesh or no other.
pub(crate) fn read_folder(folder: &Path) -> Result<ShapedMesh, FileError> {
    let blame = |error: FormatError| FileError { file: folder.to_owned(), error };
    let entries = std::fs::read_dir(folder).map_err(|error| blame(FormatError::Read(error)))?;
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| blame(FormatError::Read(error)))?.path();
        if extension(&path) == "obj" {
            files.push(path);
        }
    }
    files.sort();
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let neutral = files.iter().position(|path| name(path).to_lowercase() == NEUTRAL);
    let neutral = neutral.ok_or_else(|| blame(ObjError::NoNeutral.into()))?;
    let neutral = files.remove(neutral);
    if files.is_empty() {
        return Err(blame(ObjError::NoShapes.into()));
    }
    let Parsed { positions, polygons, corners, texture, .. } = read(&neutral)?;
    let faces: Vec<Vec<usize>> = polygons.iter().map(<[usize]>::to_vec).collect();
    if faces.iter().all(|face| face.len() < 3) {
        return Err(FileError { file: neutral, error: ObjError::NoFaces.into() });
    }
    let mut left = corners.iter().map(|corner| corner.texture);
    let uv_faces: Option<Vec<Vec<usize>>> =
        faces.iter().map(|face| left.by_ref().take(face.len()).collect()).collect();
    let uv_faces = uv_faces.filter(|_| !texture.is_empty());
    let mut shapes = Vec::new();
    for file in files {
        let found = read(&file)?.positions;
        if found.len() != positions.len() {
            let error = ObjError::Vertices { expected: positions.len(), found: found.len() };
            return Err(FileError { file, error: error.into() });
        }
        let by = |(at, from): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|axis| at[axis] - from[axis]);
        let deltas = found.iter().zip(&positions).map(by).collect();
        shapes.push(NamedShape { name: name(&file), deltas });
    }
    let uv = if uv_faces.is_some() { texture } else { Vec::new() };
    let uv_faces = uv_faces.unwrap_or_default();
    Ok(ShapedMesh { positions, faces, uv, uv_faces, shapes, ..ShapedMesh::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::testing::Folder;

    const NEUTRAL_TEXT: &str =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3 4/1\n";
    const SMILE: &str = "v 0 0 0\nv 1 0 0.5\nv 1 1 0\nv -1 1 0\n";

    fn said(folder: &Folder) -> String {
        read_folder(&folder.0).unwrap_err().to_string()
    }

    #[test]
    fn files_beside_the_neutral_one_are_shapes_by_name() {
        let folder = Folder::new("obj-shapes");
        folder.write("neutral.obj", NEUTRAL_TEXT);
        folder.write("smile.obj", SMILE);
        folder.write("blink.obj", NEUTRAL_TEXT);
        folder.write("notes.txt", "no mesh");
        let mesh = read_folder(&folder.0).unwrap();
        let names: Vec<_> = mesh.shapes.iter().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, ["blink", "smile"]);
        assert_eq!(mesh.shapes[0].deltas, [[0.0; 3]; 4]);
        let expected = [[0.0; 3], [0.0, 0.0, 0.5], [0.0; 3], [-1.0, 0.0, 0.0]];
        assert_eq!(mesh.shapes[1].deltas, expected);
        assert_eq!((mesh.faces, mesh.uv_faces), (vec![vec![0, 1, 2, 3]], vec![vec![0, 1, 2, 0]]));
        assert_eq!(mesh.uv, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    }

    #[test]
    fn what_is_no_face_is_told() {
        let folder = Folder::new("obj-none");
        assert!(said(&folder).contains("has no neutral.obj"), "{}", said(&folder));
        folder.write("neutral.obj", NEUTRAL_TEXT);
        assert!(said(&folder).contains("has no shape beside neutral.obj"), "{}", said(&folder));
        folder.write("smile.obj", "v 0 0 0\nf 1 1 1\n");
        let error = said(&folder);
        assert!(
            error.ends_with("smile.obj: expected 4 vertices, as neutral.obj has, found 1"),
            "{error}"
        );
        folder.write("smile.obj", "v 0 0\n");
        assert!(said(&folder).contains("smile.obj: line 1 is no vertex"), "{}", said(&folder));
        folder.write("neutral.obj", "v 0 0 0\n");
        assert!(said(&folder).contains("neutral.obj: has no face"), "{}", said(&folder));
    }
}
