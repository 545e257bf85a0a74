//! What is told of the vertices: the meshes that they are of, the joints that they were bound to, and how much each
//! counts.

use super::fields::read_each;
use super::runs::{RunKind, Runs, read_runs};
use super::sidecar::Sidecar;
use crate::examples::ExamplesError;
use crate::examples::validate::same;
use crate::formats::npz::Archive;

/// Meshes, as runs of vertices.
pub(super) const MESHES: RunKind =
    RunKind { what: "meshes", names: "mesh_names", starts: "mesh_starts" };

/// Reads the meshes that V vertices are of; none where none is named.
///
/// # Errors
/// Those of [`read_runs`].
pub(super) fn read_meshes(
    archive: &mut Archive,
    sidecar: &Sidecar,
    vertex_len: usize,
) -> Result<Runs, ExamplesError> {
    let (names, starts) = (sidecar.mesh_names.as_ref(), sidecar.mesh_starts.as_ref());
    Ok(read_runs(archive, &MESHES, names, starts, vertex_len)?.unwrap_or_default())
}

/// Reads the weights of J joints on V vertices.
///
/// # Errors
/// Those of the array, [`ExamplesError::Mismatch`] for other counts.
pub(super) fn read_joint_weights(
    archive: &mut Archive,
    [vertex_len, joint_len]: [usize; 2],
) -> Result<Option<Vec<f64>>, ExamplesError> {
    let Some(rows) = archive.rows::<f64, 1>("joint_weights", &[0])? else { return Ok(None) };
    same("vertices", "rest", vertex_len, "joint_weights", rows.lead[0])?;
    same("joints", "bone_names", joint_len, "joint_weights", rows.lead[1])?;
    Ok(Some(rows.data.into_iter().flatten().collect()))
}

/// Reads how much each of V vertices counts.
///
/// # Errors
/// Those of the array, [`ExamplesError::Mismatch`] for another count.
pub(super) fn read_importance(
    archive: &mut Archive,
    vertex_len: usize,
) -> Result<Option<Vec<f64>>, ExamplesError> {
    read_each(archive, "importance", ("vertices", "rest", vertex_len))
}
