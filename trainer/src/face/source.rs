//! Reads faces from every supported format.
//!
//! A face in a `.npz` has these arrays. Shapes: `neutral` (V, 3), `expression_deltas` (S, V, 3) and `expression_names`
//! (S). Faces: `quads` and `tris`. Texture: `uv`, with faces `uv_quads` and `uv_tris`. Others: `identity_deltas` (I, V,
//! 3) and `landmarks`.
//!
//! Example meshes have `meshes` (N, V, 3), or (N, V, 2) for points in a plane, and faces `quads` and `tris`.

use super::basis::{Basis, ExampleMeshes, no_vertex, not_finite};
use crate::Error;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::npz::{self, Archive};
use crate::formats::obj::read_folder;
use crate::formats::{NamedShape, ShapedMesh, fbx, gltf};
use serde_json::Value;
use std::path::Path;

/// ICT-FaceKit's head: numbers of vertices and faces, and the ends of its vertex regions (its README, "Geometry").
const ICT: ([usize; 2], [(&str, usize); 3]) =
    ([11_248, 11_144], [("narrow_face", 6706), ("face", 9409), ("head_and_neck", 11_248)]);
/// ICT-FaceKit's landmarks: a JSON file beside the head, and the list in it.
const ICT_LANDMARKS: (&str, &str) = ("vertex_indices.json", "idx_to_landmark_verts");

/// Contents of a face file.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A neutral mesh with named shapes.
    Shapes(Basis),
    /// Example meshes without shapes.
    Meshes(ExampleMeshes),
}

/// Reads a face: a `.npz`, a scene with morph targets (`.glb`, `.gltf`, `.fbx`), or a folder of OBJ files.
///
/// # Errors
/// The file cannot be read, has another ending, or is damaged; an array of a `.npz` is missing, or does not fit the
/// others; there is no shape, two shapes have the same name, or a number is not finite.
pub fn read(path: &Path) -> Result<Source, Error> {
    if path.is_dir() {
        return Basis::of(read_folder(path)?).check().map(Source::Shapes);
    }
    let mesh = match extension(path).as_str() {
        "npz" => return read_arrays(path),
        "glb" | "gltf" => gltf::read_shapes(path)?,
        "fbx" => fbx::read_shapes(path)?,
        _ => return Err(unknown_format(path, ".npz, .glb, .gltf or .fbx, or a folder")),
    };
    Basis::of(mesh).check().map(Source::Shapes)
}

/// Reads a face with shapes, or example meshes, from arrays.
fn read_arrays(path: &Path) -> Result<Source, Error> {
    let mut archive = Archive::open(path)?;
    let names = archive.texts("expression_names")?;
    if names.is_none() && archive.rows::<f64, 3>("neutral", &[3])?.is_none() {
        return read_meshes(&mut archive).map(Source::Meshes);
    }
    let positions = archive.required::<f64, 3>("neutral", &[3])?.data;
    let len = positions.len();
    let faces = faces(&mut archive, ["quads", "tris"], len)?;
    let uv = archive.rows::<f64, 2>("uv", &[2])?.map(|rows| rows.data).unwrap_or_default();
    let mut uv_faces = Vec::new();
    if !uv.is_empty() {
        uv_faces = self::faces(&mut archive, ["uv_quads", "uv_tris"], uv.len())?;
        count("uv_quads", "faces", faces.len(), uv_faces.len())?;
        for (face, uv) in faces.iter().zip(&uv_faces) {
            count("uv_quads", "corners in a face", face.len(), uv.len())?;
        }
    }
    let deltas = deltas(&mut archive, "expression_deltas", len)?;
    let names =
        names.unwrap_or_else(|| (0..deltas.len()).map(|shape| format!("shape {shape}")).collect());
    count("expression_names", "names", deltas.len(), names.len())?;
    let shapes = names.into_iter().zip(deltas);
    let shapes = shapes.map(|(name, deltas)| NamedShape { name, deltas }).collect();
    let identities = self::deltas(&mut archive, "identity_deltas", len)?;
    let landmarks = archive.rows::<i64, 1>("landmarks", &[])?.map(|rows| rows.data);
    let landmarks = landmarks.unwrap_or_default();
    let place = || "array landmarks".to_owned();
    let mut landmarks = checked(place, landmarks.as_flattened(), len)?;
    let mut regions = Vec::new();
    let (own, ends) = ICT;
    if [len, faces.len()] == own {
        let mut first = 0;
        for (name, end) in ends {
            regions.push((name.to_owned(), first..end));
            first = end;
        }
        if landmarks.is_empty() {
            landmarks = ict_landmarks(path, len);
        }
    }
    let mesh = ShapedMesh { positions, faces, uv, uv_faces, shapes, ..ShapedMesh::default() };
    Basis { mesh, identities, landmarks, regions }.check().map(Source::Shapes)
}

/// Reads example meshes from arrays; points in a plane get z = 0.
fn read_meshes(archive: &mut Archive) -> Result<ExampleMeshes, Error> {
    let in_space = archive.rows::<f64, 3>("meshes", &[0, 3]);
    let (lead, points) = match in_space {
        Ok(Some(rows)) => (rows.lead, rows.data),
        Ok(None) => {
            let array = "neutral, with expression_deltas and expression_names, or meshes";
            return Err(npz::missing(array));
        }
        Err(error) => match archive.rows::<f64, 2>("meshes", &[0, 2]) {
            Ok(Some(rows)) => (rows.lead, rows.data.iter().map(|&[x, y]| [x, y, 0.0]).collect()),
            _ => return Err(error),
        },
    };
    let (n, len) = (lead[0], lead[1]);
    if n < 2 {
        return Err(wrong_count("meshes", "meshes or more", 2, n));
    }
    if !points.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(not_finite("meshes"));
    }
    let positions: Vec<Vec<[f64; 3]>> = points.chunks(len.max(1)).map(<[_]>::to_vec).collect();
    count("meshes", "meshes with vertices", n, positions.len())?;
    let faces = faces(archive, ["quads", "tris"], len)?;
    let mesh = ShapedMesh { positions: positions[0].clone(), faces, ..ShapedMesh::default() };
    Ok(ExampleMeshes { mesh, positions })
}

/// Reads faces and checks that their corners are below `len`.
fn faces(
    archive: &mut Archive,
    [quads, tris]: [&'static str; 2],
    len: usize,
) -> Result<Vec<Vec<usize>>, Error> {
    let mut out = Vec::new();
    let of_quads = archive.rows::<i64, 4>(quads, &[4])?.map(|rows| rows.data);
    for (face, corners) in of_quads.iter().flatten().enumerate() {
        out.push(checked(|| format!("face {face} of {quads}"), corners, len)?);
    }
    let of_tris = archive.rows::<i64, 3>(tris, &[3])?.map(|rows| rows.data);
    for (face, corners) in of_tris.iter().flatten().enumerate() {
        out.push(checked(|| format!("face {face} of {tris}"), corners, len)?);
    }
    Ok(out)
}

fn checked(place: impl Fn() -> String, numbers: &[i64], len: usize) -> Result<Vec<usize>, Error> {
    let check = |&found: &i64| match usize::try_from(found) {
        Ok(vertex) if vertex < len => Ok(vertex),
        _ => Err(no_vertex(&place(), found, len)),
    };
    numbers.iter().map(check).collect()
}

fn deltas(
    archive: &mut Archive,
    array: &'static str,
    len: usize,
) -> Result<Vec<Vec<[f64; 3]>>, Error> {
    let Some(rows) = archive.rows::<f64, 3>(array, &[0, 3])? else { return Ok(Vec::new()) };
    count(array, "vertices", len, rows.lead[1])?;
    Ok(rows.data.chunks(len.max(1)).map(<[_]>::to_vec).collect())
}

/// Checks the length of an array.
pub(super) fn count(array: &str, what: &str, expected: usize, found: usize) -> Result<(), Error> {
    if expected == found {
        return Ok(());
    }
    Err(wrong_count(array, what, expected, found))
}

fn wrong_count(array: &str, what: &str, expected: usize, found: usize) -> Error {
    Error::mismatch(format!("array {array}: expected {expected} {what}, found {found}"))
}

/// Reads ICT-FaceKit's landmarks from the file beside its head; empty without that file.
fn ict_landmarks(path: &Path, len: usize) -> Vec<usize> {
    let (file, list) = ICT_LANDMARKS;
    let text = std::fs::read(path.with_file_name(file));
    let json = text.ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
    let list = json.as_ref().and_then(|json| json[list].as_array());
    let numbers = list.into_iter().flatten().filter_map(Value::as_u64);
    numbers.map(|vertex| vertex as usize).filter(|vertex| *vertex < len).collect()
}
