//! FBX: skinned meshes, or a mesh beside a skeleton, and their animations.
//!
//! Units and axes stay as they are in the file. Vertices are its control points, in their order; the meshes of several
//! nodes follow one another in the order of the nodes.

pub(super) mod appearance;
mod curves;
mod file;
mod frames;
mod meshes;
#[cfg(test)]
mod tests;

pub(crate) use meshes::read_shapes;

use super::mesh::{Mesh, MeshFile};
use super::scene::{JointNames, Motion, MotionJoints, SampledScene, Sampling};
use crate::Error;
use curves::named_channels;
use file::{open, space};
use frames::{Joints, Posed, at_rest, bind, hierarchy};
use meshes::Geometry;
use nalgebra::Matrix4;
use std::path::Path;
use ufbx::Scene;

/// Reads a scene.
///
/// Joints are the nodes of skins and the bones above them; without a skin, all bones. An animation with keys on the
/// joints, or on nodes above them, is a clip. Clips are sampled at their keys, or as `sampling` says.
///
/// Posed positions come from blendshapes and then the skin, linear or by dual quaternions. There are none without a
/// skin, or if a point cache outside the file deforms a mesh.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged: the error says what to export.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, Error> {
    parse(&std::fs::read(path).map_err(Error::read)?, sampling)
}

/// Reads the meshes of a file as one mesh: skinned meshes in their bind pose; without any skin, all meshes as their
/// nodes place them.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(in crate::formats) fn read_mesh(path: &Path) -> Result<MeshFile, Error> {
    let bytes = std::fs::read(path).map_err(Error::read)?;
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
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read_motion(
    path: &Path,
    character: &[String],
    joint_names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, Error> {
    let bytes = std::fs::read(path).map_err(Error::read)?;
    let scene = open(&bytes)?;
    let mut binds = vec![None; scene.nodes.len()];
    for part in meshes::parts(&scene, &mut Vec::new()).unwrap_or_default() {
        bind(&scene, &part, &mut binds)?;
    }
    let joints = MotionJoints::find(candidates(&scene, &binds), character, joint_names)?;
    let found = &joints.nodes;
    let mut warnings = Vec::new();
    let takes = frames::takes(&scene, found, &[], sampling, &mut warnings)?;
    let named = named_channels(&scene, sampling);
    let Posed { joints: frames, curves, .. } = frames::posed(&scene, &takes, found, None, &named)?;
    let rest: Vec<_> = scene.nodes.iter().map(|node| at_rest(node)).collect();
    let tree = hierarchy(&scene);
    let binds = found.iter().map(|&node| tree.bound(node, &binds, &rest));
    Ok(Motion {
        space: space(&scene.settings),
        rest: found.iter().map(|&node| rest[node]).collect(),
        binds: binds.collect(),
        frames,
        curves,
        joints,
        clips: frames::clips(takes),
        warnings,
    })
}

/// Returns the names of the nodes that may be joints, if a file shows nodes but no mesh. `None` also for a file that
/// cannot be read.
pub(crate) fn joints_alone(path: &Path) -> Option<Vec<String>> {
    let scene = open(&std::fs::read(path).ok()?).ok()?;
    // The root node always exists.
    if meshes::shown(&scene).next().is_some() || scene.nodes.len() < 2 {
        return None;
    }
    let all = candidates(&scene, &vec![None; scene.nodes.len()]);
    Some(all.into_iter().map(|(_, name)| name).collect())
}

/// Lists the nodes that may be joints, with unique names; bones and joints of skins come first.
///
/// - `binds`: bind frames of the nodes that are joints of skins.
fn candidates(scene: &Scene, binds: &[Option<Matrix4<f64>>]) -> Vec<(usize, String)> {
    let is_bone = |node: usize| scene.nodes[node].bone.is_some() || binds[node].is_some();
    hierarchy(scene).candidates(is_bone, |node| scene.nodes[node].mesh.is_some())
}

fn parse(bytes: &[u8], sampling: &Sampling<'_>) -> Result<SampledScene, Error> {
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
    let named = named_channels(&scene, sampling);
    let Posed { joints: frames, shapes, morphs, curves } =
        frames::posed(&scene, &takes, &nodes, shown, &named)?;
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
        at_rest: nodes.iter().map(|&node| at_rest(&scene.nodes[node])).collect(),
        frames,
        curves,
        shapes,
        morphs,
        clips: frames::clips(takes),
        warnings,
    })
}
