//! The triangles of primitives, whatever mode lists them.

use gltf::Primitive;
use gltf::accessor::DataType;
use gltf::mesh::Mode;

use super::accessor::numbers;
use super::file::Buffers;
use crate::formats::scene::SceneError;

/// Returns true for a primitive of triangles, and false for points and lines.
pub(super) fn is_surface(primitive: &Primitive<'_>) -> bool {
    matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Lists the corners of a primitive's triangles, as numbers of its `vertex_len` vertices.
///
/// Strips and fans may repeat a corner to join two parts: such triangles are left out. The largest index of a type
/// restarts a strip or fan, as in engines.
///
/// # Errors
/// [`SceneError::Accessor`]; [`SceneError::NoSuch`] for a vertex that is not there; [`SceneError::Count`] where a list
/// ends within a triangle.
pub(super) fn triangles(
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    vertex_len: usize,
    place: impl Fn() -> String,
) -> Result<Vec<[usize; 3]>, SceneError> {
    let mode = primitive.mode();
    let indices = primitive.indices();
    let restart = indices.as_ref().and_then(|indices| restart(indices.data_type()));
    let corners: Vec<usize> = match indices {
        Some(indices) => numbers(&indices, buffers, 1)?.into_iter().map(|x| x as usize).collect(),
        None => (0..vertex_len).collect(),
    };
    let is_restart = |corner: &usize| mode != Mode::Triangles && Some(*corner) == restart;
    let missing = |corner: &&usize| **corner >= vertex_len && !is_restart(corner);
    if let Some(&found) = corners.iter().find(missing) {
        return Err(SceneError::NoSuch { place: place(), what: "vertex", found, len: vertex_len });
    }
    if mode == Mode::Triangles {
        let (triangles, rest) = corners.as_chunks::<3>();
        if !rest.is_empty() {
            let (expected, found) = (3 * triangles.len(), corners.len());
            let what = "corners in whole triangles";
            return Err(SceneError::Count { place: place(), what, expected, found });
        }
        return Ok(triangles.to_vec());
    }
    let runs = corners.split(is_restart);
    let of_run = |run: &[usize]| -> Vec<[usize; 3]> {
        let triangle = |(number, own): (usize, &[usize])| match (mode, number % 2) {
            (Mode::TriangleFan, _) => [own[1], own[2], run[0]],
            (_, 0) => [own[0], own[1], own[2]],
            _ => [own[0], own[2], own[1]],
        };
        run.windows(3).enumerate().map(triangle).collect()
    };
    let all = runs.flat_map(of_run);
    Ok(all.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

/// Gives the index that restarts a strip.
fn restart(kind: DataType) -> Option<usize> {
    match kind {
        DataType::U8 => Some(u8::MAX.into()),
        DataType::U16 => Some(u16::MAX.into()),
        DataType::U32 => usize::try_from(u32::MAX).ok(),
        _ => None,
    }
}
