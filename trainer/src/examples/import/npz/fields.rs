//! Fields that examples and targets both have.

use crate::examples::validate::same;
use crate::examples::{ExamplesError, Split};
use crate::formats::npz::{Archive, Number};
use crate::formats::{ArrayError, FormatError};

/// Names of the arrays of faces: quads, then triangles.
pub(super) const FACES: [&str; 2] = ["quads", "tris"];

/// Faces as triangles.
pub(super) struct Faces {
    /// What the corners of each name; quads come first, as their corners 0 1 2 and 0 2 3.
    pub(super) triangles: Vec<[usize; 3]>,
    /// How many quads and triangles there are, where there is an array of them.
    pub(super) counts: [Option<usize>; 2],
}

/// Reads faces whose corners name one of so many things; `None` where neither array is there.
pub(super) fn read_faces(
    archive: &mut Archive,
    [quads, tris]: [&'static str; 2],
    len: usize,
) -> Result<Option<Faces>, ExamplesError> {
    let of_quads = archive.rows::<i64, 4>(quads, &[4])?.map(|rows| rows.data);
    let of_tris = archive.rows::<i64, 3>(tris, &[3])?.map(|rows| rows.data);
    let counts = [of_quads.as_ref().map(Vec::len), of_tris.as_ref().map(Vec::len)];
    if counts == [None, None] {
        return Ok(None);
    }
    let mut triangles = Vec::new();
    for (face, quad) in of_quads.iter().flatten().enumerate() {
        let [a, b, c, d] = corners(quads, face, quad, len)?;
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    for (face, triangle) in of_tris.iter().flatten().enumerate() {
        triangles.push(corners(tris, face, triangle, len)?);
    }
    Ok(Some(Faces { triangles, counts }))
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
    let codes = read_each::<i64>(archive, "split", ("frames", "vertices", frame_len))?;
    let Some(codes) = codes else { return Ok(None) };
    let split = codes.into_iter().enumerate().map(|(frame, code)| match code {
        0 => Ok(Split::Train),
        1 => Ok(Split::HeldOut),
        2 => Ok(Split::Extreme),
        _ => Err(ExamplesError::UnknownSplit { frame, code }),
    });
    split.collect::<Result<_, _>>().map(Some)
}

/// Reads how often each of N frames counts.
///
/// # Errors
/// Those of the array, [`ExamplesError::Mismatch`] for another count.
pub(super) fn read_frame_weights(
    archive: &mut Archive,
    frame_len: usize,
) -> Result<Option<Vec<f64>>, ExamplesError> {
    read_each(archive, "frame_weights", ("frames", "vertices", frame_len))
}

/// Reads a number of each thing, of which another array has so many.
///
/// # Errors
/// Those of the array, [`ExamplesError::Mismatch`] for another count.
pub(super) fn read_each<T: Number>(
    archive: &mut Archive,
    array: &'static str,
    (things, of, len): (&'static str, &'static str, usize),
) -> Result<Option<Vec<T>>, ExamplesError> {
    let Some(numbers) = archive.rows::<T, 1>(array, &[])? else { return Ok(None) };
    same(things, of, len, array, numbers.data.len())?;
    Ok(Some(numbers.data.into_iter().map(|[number]| number).collect()))
}

/// Names an array that is not there.
pub(super) fn missing(array: &'static str) -> ExamplesError {
    FormatError::from(ArrayError::Missing { array }).into()
}
