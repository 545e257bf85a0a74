//! The motion of joints alone: of a scene with or without a mesh.

use super::frames::{self, Posed};
use super::joints::at_rest;
use super::read::{open, space};
use crate::formats::error::FormatError;
use crate::formats::scene::{Motion, Sampling};
use std::path::Path;

/// Reads how the nodes of some names move.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read_motion(
    path: &Path,
    joints: &[String],
    sampling: &Sampling<'_>,
) -> Result<Motion, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    let scene = open(&bytes)?;
    let name = |node: usize| scene.nodes[node].element.name.to_string();
    let found: Vec<usize> =
        (0..scene.nodes.len()).filter(|&node| joints.contains(&name(node))).collect();
    let mut warnings = Vec::new();
    let takes = frames::takes(&scene, &found, &[], sampling, &mut warnings)?;
    let Posed { joints: frames, .. } = frames::posed(&scene, &takes, &found, None)?;
    Ok(Motion {
        space: space(&scene.settings),
        names: found.iter().map(|&node| name(node)).collect(),
        rest: found.iter().map(|&node| at_rest(&scene.nodes[node])).collect(),
        frames,
        clips: frames::clips(takes),
        warnings,
    })
}
