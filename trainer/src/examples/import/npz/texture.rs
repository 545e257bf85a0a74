//! Texture coordinates, by vertex or by corner.

use super::fields::{FACES, Faces, read_faces};
use crate::examples::ExamplesError;
use crate::examples::validate::same;
use crate::formats::npz::Archive;
use crate::mesh::EngineMesh;

/// Names of the arrays that say which coordinates the corners of quads and triangles have, the usual ones first.
const BY_CORNER: [[&str; 2]; 2] = [["quads_uv", "tris_uv"], ["uv_quads", "uv_tris"]];

/// Reads texture coordinates: one a vertex, or any number of them and which each corner of the faces has. `None`
/// where there are none.
///
/// # Errors
/// Those of the arrays, [`ExamplesError::Mismatch`] for another count of coordinates or faces, and
/// [`ExamplesError::VertexOutOfRange`] for a corner that names none of them.
pub(super) fn read_texture(
    archive: &mut Archive,
    positions: &[[f64; 3]],
    faces: &Faces,
) -> Result<Option<EngineMesh>, ExamplesError> {
    let Some(uv) = archive.rows::<f64, 2>("uv", &[2])?.map(|uv| uv.data) else { return Ok(None) };
    let mut by_corner = None;
    for names in BY_CORNER {
        if by_corner.is_none() {
            by_corner = read_faces(archive, names, uv.len())?.map(|found| (names, found));
        }
    }
    let triangles = &faces.triangles;
    let Some((names, found)) = by_corner else {
        same("vertices", "rest", positions.len(), "uv", uv.len())?;
        return Ok(Some(EngineMesh::of_vertices(positions, triangles, &uv)));
    };
    for kind in 0..2 {
        let [expected, found] = [faces, &found].map(|faces| faces.counts[kind].unwrap_or(0));
        same("faces", FACES[kind], expected, names[kind], found)?;
    }
    let uv = found.triangles.as_flattened().iter().map(|&place| uv[place]).collect();
    Ok(Some(EngineMesh::of_corners(positions, triangles, uv)))
}
