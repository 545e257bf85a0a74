//! Faces as arrays: `neutral` (V, 3), `expression_deltas` (S, V, 3) and `expression_names` (S); faces as `quads` and
//! `tris`, of texture coordinates `uv` as `uv_quads` and `uv_tris`; `identity_deltas` (I, V, 3); `landmarks`.

use super::basis::Basis;
use super::error::FaceError;
use crate::formats::npz::Archive;
use crate::formats::{FormatError, NamedShape, ShapedMesh};
use serde_json::Value;
use std::path::Path;

/// Vertices and faces of the head of ICT-FaceKit, and its regions of vertices (its README, "Geometry").
const ICT: ([usize; 2], [(&str, usize); 3]) =
    ([11_248, 11_144], [("narrow_face", 6706), ("face", 9409), ("head_and_neck", 11_248)]);
/// What ICT-FaceKit has beside its head.
const ICT_LANDMARKS: (&str, &str) = ("vertex_indices.json", "idx_to_landmark_verts");

/// Tells whether a file has shapes.
pub(super) fn has_shapes(path: &Path) -> Result<bool, FaceError> {
    let mut archive = Archive::open(path)?;
    let names = archive.texts("expression_names")?;
    Ok(names.is_some() || archive.rows::<f64, 3>("neutral", &[3])?.is_some())
}

/// Reads a face.
pub(super) fn read(path: &Path) -> Result<Basis, FaceError> {
    let mut archive = Archive::open(path)?;
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
    let names = archive.texts("expression_names")?;
    let names =
        names.unwrap_or_else(|| (0..deltas.len()).map(|shape| format!("shape {shape}")).collect());
    count("expression_names", "names", deltas.len(), names.len())?;
    let shapes = names.into_iter().zip(deltas);
    let shapes = shapes.map(|(name, deltas)| NamedShape { name, deltas }).collect();
    let identities = self::deltas(&mut archive, "identity_deltas", len)?;
    let mut landmarks = vertices("landmarks", archive.rows::<i64, 1>("landmarks", &[])?, len)?;
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
    Ok(Basis { mesh, identities, landmarks, regions })
}

/// Reads faces whose corners name one of so many things.
pub(super) fn faces(
    archive: &mut Archive,
    [quads, tris]: [&'static str; 2],
    len: usize,
) -> Result<Vec<Vec<usize>>, FaceError> {
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

fn checked(
    place: impl Fn() -> String,
    numbers: &[i64],
    len: usize,
) -> Result<Vec<usize>, FaceError> {
    let check = |&found: &i64| match usize::try_from(found) {
        Ok(vertex) if vertex < len => Ok(vertex),
        _ => Err(FaceError::Vertex { place: place(), found, len }),
    };
    numbers.iter().map(check).collect()
}

fn vertices(
    array: &'static str,
    rows: Option<crate::formats::npz::Rows<i64, 1>>,
    len: usize,
) -> Result<Vec<usize>, FaceError> {
    let numbers = rows.map(|rows| rows.data).unwrap_or_default();
    checked(|| format!("array {array}"), numbers.as_flattened(), len)
}

fn deltas(
    archive: &mut Archive,
    array: &'static str,
    len: usize,
) -> Result<Vec<Vec<[f64; 3]>>, FaceError> {
    let Some(rows) = archive.rows::<f64, 3>(array, &[0, 3])? else { return Ok(Vec::new()) };
    count(array, "vertices", len, rows.lead[1])?;
    Ok(rows.data.chunks(len.max(1)).map(<[_]>::to_vec).collect())
}

pub(super) fn count(
    array: &'static str,
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), FaceError> {
    if expected == found {
        return Ok(());
    }
    Err(FaceError::Count { array, what, expected, found })
}

/// Reads the landmarks that ICT-FaceKit has beside its head; none where there is no such file.
fn ict_landmarks(path: &Path, len: usize) -> Vec<usize> {
    let (file, list) = ICT_LANDMARKS;
    let text = std::fs::read(path.with_file_name(file)).map_err(FormatError::Read);
    let json = text.ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
    let list = json.as_ref().and_then(|json| json[list].as_array());
    let numbers = list.into_iter().flatten().filter_map(Value::as_u64);
    numbers.map(|vertex| vertex as usize).filter(|vertex| *vertex < len).collect()
}
