//! The motion of joints alone: of a scene with or without a mesh.

use super::frames::{self, Posed};
use super::joints::{at_rest, bind, names, upwards};
use super::meshes;
use super::read::{open, space};
use crate::formats::error::FormatError;
use crate::formats::scene::{JointNames, Motion, MotionJoints, Sampling, bound};
use std::path::Path;

/// Reads how the nodes move that are joints of a character by name.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read_motion(
    path: &Path,
    character: &[String],
    joint_names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    let scene = open(&bytes)?;
    let mut binds = vec![None; scene.nodes.len()];
    for part in meshes::parts(&scene, &mut Vec::new()).unwrap_or_default() {
        bind(&scene, &part, &mut binds)?;
    }
    let is_bone = |node: usize| scene.nodes[node].bone.is_some() || binds[node].is_some();
    let (labels, _) = names(&scene, is_bone);
    let shows = |node: usize| scene.nodes[node].mesh.is_some();
    let mut candidates: Vec<usize> = (0..labels.len()).filter(|&node| !shows(node)).collect();
    candidates.sort_by_key(|&node| !is_bone(node));
    let candidates = candidates.into_iter().map(|node| (node, labels[node].as_str()));
    let joints = MotionJoints::find(candidates, character, joint_names)?;
    let found = &joints.nodes;
    let mut warnings = Vec::new();
    let takes = frames::takes(&scene, found, &[], sampling, &mut warnings)?;
    let Posed { joints: frames, .. } = frames::posed(&scene, &takes, found, None)?;
    let rest: Vec<_> = scene.nodes.iter().map(|node| at_rest(node)).collect();
    let binds = found.iter().map(|&node| bound(upwards(&scene, node), &binds, &rest));
    Ok(Motion {
        space: space(&scene.settings),
        rest: found.iter().map(|&node| rest[node]).collect(),
        binds: binds.collect(),
        frames,
        joints,
        clips: frames::clips(takes),
        warnings,
    })
}
