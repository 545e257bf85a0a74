//! Posed meshes alone, from the same arrays as examples.

use std::path::Path;

use super::fields::{FACES, read_faces, read_split};
use crate::examples::validate::same;
use crate::examples::{ExamplesError, Split};
use crate::formats::npz::{Archive, Rows};
use crate::formats::posed_meshes::PosedMeshes;

/// Reads `vertices`, and `rest` and the faces where they are there; and `split`, the use of each frame.
pub(in crate::examples::import) fn read_posed_meshes(
    path: &Path,
) -> Result<(PosedMeshes, Option<Vec<Split>>), ExamplesError> {
    let mut archive = Archive::open(path)?;
    let Rows { lead, data: vertices } = archive.required::<f64, 3>("vertices", &[0, 3])?;
    let (frame_len, vertex_len) = (lead[0], lead[1]);
    let rest = archive.rows::<f64, 3>("rest", &[3])?.map(|rest| rest.data);
    if let Some(rest) = &rest {
        same("vertices", "rest", rest.len(), "vertices", vertex_len)?;
    }
    let faces = read_faces(&mut archive, FACES, vertex_len)?;
    let triangles = faces.map(|faces| faces.triangles);
    let split = read_split(&mut archive, frame_len)?;
    Ok((PosedMeshes { rest, triangles, ..PosedMeshes::bare(vertex_len, vertices) }, split))
}
