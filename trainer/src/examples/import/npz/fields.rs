//! Fields that examples and targets both have.

use crate::examples::validate::same;
use crate::examples::{ExamplesError, Split};
use crate::formats::npz::Archive;

/// Reads the faces, triangles and quads.
pub(super) fn read_triangles(
    archive: &mut Archive,
    vertex_len: usize,
) -> Result<Option<Vec<[usize; 3]>>, ExamplesError> {
    let quads = archive.rows::<i64, 4>("quads", &[4])?;
    let tris = archive.rows::<i64, 3>("tris", &[3])?;
    if quads.is_none() && tris.is_none() {
        return Ok(None);
    }
    let mut triangles = Vec::new();
    for (face, quad) in quads.iter().flat_map(|quads| &quads.data).enumerate() {
        let [a, b, c, d] = corners("quads", face, quad, vertex_len)?;
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    for (face, triangle) in tris.iter().flat_map(|tris| &tris.data).enumerate() {
        triangles.push(corners("tris", face, triangle, vertex_len)?);
    }
    Ok(Some(triangles))
}

fn corners<const K: usize>(
    array: &'static str,
    face: usize,
    corners: &[i64; K],
    vertex_len: usize,
) -> Result<[usize; K], ExamplesError> {
    let mut checked = [0; K];
    for (corner, &vertex) in checked.iter_mut().zip(corners) {
        match usize::try_from(vertex) {
            Ok(inside) if inside < vertex_len => *corner = inside,
            _ => return Err(ExamplesError::VertexOutOfRange { array, face, vertex, vertex_len }),
        }
    }
    Ok(checked)
}

/// Reads the use of each frame.
pub(super) fn read_split(
    archive: &mut Archive,
    frame_len: usize,
) -> Result<Option<Vec<Split>>, ExamplesError> {
    let Some(codes) = archive.rows::<i64, 1>("split", &[])? else { return Ok(None) };
    same("frames", "vertices", frame_len, "split", codes.data.len())?;
    let codes = codes.data.iter().enumerate();
    let split = codes.map(|(frame, &[code])| match code {
        0 => Ok(Split::Train),
        1 => Ok(Split::HeldOut),
        2 => Ok(Split::Extreme),
        _ => Err(ExamplesError::UnknownSplit { frame, code }),
    });
    split.collect::<Result<_, _>>().map(Some)
}
