//! The motion of joints alone: of a scene with or without a mesh.

use super::clips::ClipKeys;
use super::file::{self, Parsed};
use super::meshes::{Meshes, Wanted};
use super::nodes::Nodes;
use super::skins::Skins;
use super::viewed::Scene;
use crate::formats::error::FormatError;
use crate::formats::scene::{
    JointNames, Motion, MotionJoints, Sampling, SceneError, bound, told_apart,
};
use sinew_runtime::format::Space;
use std::path::Path;

/// Reads how the nodes move that are joints of a character by name.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read_motion(
    path: &Path,
    character: &[String],
    names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, FormatError> {
    let parsed = file::open(path)?;
    let Parsed { document, buffers, .. } = &parsed;
    let nodes = Nodes::read(document)?;
    if nodes.names.is_empty() {
        return Err(SceneError::Empty.into());
    }
    // Skins that disagree have no common rest pose; the nodes have one.
    let skins = Skins::all(document, buffers, &nodes).unwrap_or_default();
    let shows: Vec<bool> = document.nodes().map(|node| node.mesh().is_some()).collect();
    // Without a skin, whatever shows no mesh; of an armature called as a joint below it, the joint.
    let below = |node: usize, other: &usize| {
        let above = nodes.upwards(*other).skip(1).any(|above| above == node);
        above && nodes.names[*other] == nodes.names[node] && !shows[*other]
    };
    let is_joint = |node: usize| match skins.joints.is_empty() {
        false => skins.joints.contains(&node),
        true => !shows[node] && !(0..shows.len()).any(|other| below(node, &other)),
    };
    let (labels, _) = told_apart(&nodes.names, &nodes.parents, is_joint);
    let mut candidates: Vec<usize> = (0..labels.len()).filter(|&node| !shows[node]).collect();
    candidates.sort_by_key(|&node| !is_joint(node));
    let candidates = candidates.into_iter().map(|node| (node, labels[node].as_str()));
    let joints = MotionJoints::find(candidates, character, names)?;
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let meshes = Meshes::read(document, buffers, |_| false, wanted)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(document, buffers)?);
    let found = &joints.nodes;
    let mut warnings = Vec::from_iter(parsed.warning());
    let (clips, moments) = scene.sample(found, sampling, &mut warnings)?;
    let at_rest = scene.nodes.worlds(&scene.nodes.locals);
    let mut binds = vec![None; at_rest.len()];
    for (&node, &bind) in skins.joints.iter().zip(&skins.binds) {
        binds[node] = Some(bind);
    }
    let binds = found.iter().map(|&node| bound(scene.nodes.upwards(node), &binds, &at_rest));
    let frames = moments.iter().flat_map(|moment| {
        let worlds = scene.nodes.worlds(&scene.at(moment).0);
        found.iter().map(|&node| worlds[node]).collect::<Vec<_>>()
    });
    Ok(Motion {
        space: Space::GLTF,
        rest: found.iter().map(|&node| at_rest[node]).collect(),
        binds: binds.collect(),
        frames: frames.collect(),
        joints,
        clips,
        warnings,
    })
}
