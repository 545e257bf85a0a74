//! FBX: skinned meshes, or a mesh beside a skeleton, and their animations.
//!
//! Units and axes stay as they are in the file. Vertices are its control points, in their order; the meshes of several
//! nodes follow one another in the order of the nodes.

pub(super) mod appearance;
mod file;
mod frames;
mod meshes;
#[cfg(test)]
mod tests;

pub(crate) use meshes::read_shapes;

use super::error::{FormatError, SceneError};
use super::mesh::{Mesh, MeshFile};
use super::scene::{JointNames, Motion, MotionJoints, SampledScene, Sampling, bound};
use file::{open, space};
use frames::{Joints, Posed, at_rest, bind, node_names, upwards};
use meshes::Geometry;
use std::path::Path;

/// Reads a scene.
///
/// Joints are the nodes of skins and the bones above them; without a skin, all bones. An animation with keys on the
/// joints, or on nodes above them, is a clip. Clips are sampled at their keys, or as `sampling` says.
///
/// Posed positions come from blendshapes and then the skin, linear or by dual quaternions. There are none without a
/// skin, or if a point cache outside the file deforms a mesh.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`], which names the missing part and what to export.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    Ok(parse(&bytes, sampling)?)
}

/// Reads the meshes of a file as one mesh: skinned meshes in their bind pose; without any skin, all meshes as their
/// nodes place them.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] for missing or damaged parts.
pub(in crate::formats) fn read_mesh(path: &Path) -> Result<MeshFile, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    let scene = open(&bytes)?;
    let mut warnings = Vec::new();
    let parts = meshes::parts(&scene, &mut warnings)?;
    let Geometry { rest: positions, triangles, engine, .. } =
        meshes::join(&scene, &parts, &mut warnings);
    let mesh = Mesh { positions, triangles, engine }.checked()?;
    Ok(MeshFile { mesh, space: Some(space(&scene.settings)), warnings })
}

/// Reads the motion of the nodes that are joints of a character, by name.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] for missing or damaged parts.
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
    let (labels, _) = node_names(&scene, is_bone);
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

fn parse(bytes: &[u8], sampling: &Sampling<'_>) -> Result<SampledScene, SceneError> {
    let scene = open(bytes)?;
    let mut warnings = Vec::new();
    let parts = meshes::parts(&scene, &mut warnings)?;
    let geometry = meshes::join(&scene, &parts, &mut warnings);
    let Joints { nodes, names, parents, binds } =
        frames::find_joints(&scene, &parts, &mut warnings)?;
    let takes = match sampling.still {
        true => Vec::new(),
        false => frames::takes(&scene, &nodes, &parts, sampling, &mut warnings)?,
    };
    if sampling.shapes {
        meshes::unweighted(&scene, &parts, &mut warnings);
    }
    let posed = meshes::are_posed(&scene, &parts, &mut warnings);
    let shown = (posed && sampling.shapes).then_some(parts.as_slice());
    let Posed { joints: frames, shapes, morphs } = frames::posed(&scene, &takes, &nodes, shown)?;
    Ok(SampledScene {
        rest: geometry.rest,
        triangles: geometry.triangles,
        engine: geometry.engine,
        ranges: geometry.ranges,
        joint_weights: meshes::joint_weights(&scene, &parts, &nodes),
        space: space(&scene.settings),
        names,
        parents,
        binds,
        frames,
        shapes,
        morphs,
        clips: frames::clips(takes),
        warnings,
    })
}
