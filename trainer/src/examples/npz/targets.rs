//! Posed meshes alone, from the same arrays as examples.

use std::path::Path;

use super::super::targets::Targets;
use super::arrays::{Archive, Rows};
use super::fields::{read_split, read_triangles};
use crate::examples::ExamplesError;
use crate::examples::validate::same;

/// Reads `vertices`, and `rest`, `split` and the faces where they are there.
pub(in super::super) fn read_targets(path: &Path) -> Result<Targets, ExamplesError> {
    let mut archive = Archive::open(path)?;
    let Rows { lead, data: vertices } = archive.required::<f64, 3>("vertices", &[0, 3])?;
    let (frame_len, vertex_len) = (lead[0], lead[1]);
    let rest = archive.rows::<f64, 3>("rest", &[3])?.map(|rest| rest.data);
    if let Some(rest) = &rest {
        same("vertices", "rest", rest.len(), "vertices", vertex_len)?;
    }
    let triangles = read_triangles(&mut archive, vertex_len)?;
    let split = read_split(&mut archive, frame_len)?;
    Ok(Targets { vertex_len, vertices, rest, triangles, split })
}
