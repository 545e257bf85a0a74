//! FBX: skinned meshes, or a mesh beside a skeleton, and their animations.
//!
//! Units and axes stay as they are in the file. Vertices are its control points, in their order; the meshes of several
//! nodes follow one another in the order of the nodes.

pub(super) mod appearance;
mod frames;
mod meshes;
#[cfg(test)]
mod tests;

pub(crate) use meshes::read_shapes;

use super::error::FormatError;
use super::mesh::{Mesh, MeshFile};
use super::scene::{JointNames, Motion, MotionJoints, SampledScene, Sampling, SceneError, bound};
use crate::space::{SpaceRequest, direction};
use frames::{Joints, Posed, at_rest, bind, node_names, upwards};
use meshes::Geometry;
use nalgebra::Matrix4;
use sinew_runtime::format::{Axis, Handedness, Space};
use std::path::Path;
use ufbx::{
    AllocatorOpts, CoordinateAxis, FileFormat, IndexErrorHandling, LoadOpts, SceneRoot,
    SceneSettings,
};

/// Memory that reading a file may take, in bytes for each byte of the file, with a lower and an upper limit. The factor
/// is the highest compression ratio of the format.
const MEMORY_A_BYTE: usize = 1100;
const MEMORY_LEAST: usize = 64 << 20;
const MEMORY_MOST: usize = 4 << 30;

/// Deepest hierarchy of nodes.
const DEPTH_MOST: u32 = 4096;

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

fn open(bytes: &[u8]) -> Result<SceneRoot, SceneError> {
    let memory_limit = bytes.len().saturating_mul(MEMORY_A_BYTE).clamp(MEMORY_LEAST, MEMORY_MOST);
    let allocator = || AllocatorOpts { memory_limit, ..Default::default() };
    let options = LoadOpts {
        file_format: FileFormat::Fbx,
        temp_allocator: allocator(),
        result_allocator: allocator(),
        ignore_embedded: true,
        skip_mesh_parts: true,
        index_error_handling: IndexErrorHandling::AbortLoading,
        node_depth_limit: DEPTH_MOST,
        ..Default::default()
    };
    ufbx::load_memory(bytes, options).map_err(fault)
}

/// Returns the axes and the unit that a scene states.
fn space(settings: &SceneSettings) -> Space {
    let axis = |axis: CoordinateAxis| match axis {
        CoordinateAxis::PositiveX => Some(Axis::X),
        CoordinateAxis::NegativeX => Some(Axis::MinusX),
        CoordinateAxis::PositiveY => Some(Axis::Y),
        CoordinateAxis::NegativeY => Some(Axis::MinusY),
        CoordinateAxis::PositiveZ => Some(Axis::Z),
        CoordinateAxis::NegativeZ => Some(Axis::MinusZ),
        CoordinateAxis::Unknown => None,
    };
    let [right, up, forward] =
        [settings.axes.right, settings.axes.up, settings.axes.front].map(axis);
    // FBX's right is the right of a viewer whom the character faces.
    let volume = |right, up, forward| {
        let [right, up, forward] = [right, up, forward].map(direction);
        right.cross(&up).dot(&forward)
    };
    let known = right.zip(up).zip(forward).map(|((r, u), f)| (u, f, volume(r, u, f)));
    let (up, forward, volume) = match known.filter(|(.., volume)| *volume != 0.0) {
        Some((up, forward, volume)) => (Some(up), Some(forward), volume),
        None => (up, None, 1.0),
    };
    let handedness = if volume < 0.0 { Handedness::Left } else { Handedness::Right };
    let unit = (settings.unit_meters as f32 > 0.0).then_some(settings.unit_meters as f32);
    SpaceRequest { unit, ..SpaceRequest::default() }
        .of(Space { up, forward, handedness, unit: None })
        .unwrap_or(Space { up, forward, handedness, unit: None })
}

/// Converts an error of ufbx.
fn fault(error: ufbx::Error) -> SceneError {
    SceneError::Fbx { reason: error.description.to_lowercase() }
}

/// Converts a matrix of ufbx.
fn matrix(m: &ufbx::Matrix) -> Matrix4<f64> {
    Matrix4::new(
        m.m00, m.m01, m.m02, m.m03, m.m10, m.m11, m.m12, m.m13, m.m20, m.m21, m.m22, m.m23, 0.0,
        0.0, 0.0, 1.0,
    )
}
