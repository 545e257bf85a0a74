//! Rigs from FBX files: skinned meshes, or a mesh beside a skeleton, and their animations.
//!
//! Units and axes stay as they are in the file. Vertices are its control points, in their order; the
//! meshes of several nodes follow one another in the order of the nodes.

mod frames;
mod joints;
mod meshes;

use std::path::Path;

use nalgebra::Matrix4;
use ufbx::{AllocatorOpts, FileFormat, IndexErrorHandling, LoadOpts, SceneRoot};

use self::frames::Posed;
use self::joints::Joints;
use super::rig::{Rig, Sampling};
use super::{ExamplesError, ImportError};

/// Memory that reading a file may take, whatever it claims to hold: as much for each byte of it as
/// its compression can hide, up to a limit for all.
const MEMORY_A_BYTE: usize = 1100;
const MEMORY_LEAST: usize = 64 << 20;
const MEMORY_MOST: usize = 4 << 30;

/// Deepest hierarchy of nodes.
const DEPTH_MOST: u32 = 4096;

/// Reads a rig.
///
/// Joints are the nodes that skins name and the bones above them; without a skin, all bones. Each
/// animation that has keys on them or above them is a clip, sampled where its keys are or as
/// `sampling` says. Posed positions are those of the skin, linear or by dual quaternions, over the
/// blendshapes; there are none without a skin or where a point cache outside the file deforms a mesh.
///
/// # Errors
/// [`ExamplesError::Read`], and [`ExamplesError::Import`] with what is not in it and what to export.
pub(super) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<Rig, ExamplesError> {
    let bytes = std::fs::read(path).map_err(ExamplesError::Read)?;
    Ok(parse(&bytes, sampling)?)
}

fn parse(bytes: &[u8], sampling: &Sampling<'_>) -> Result<Rig, ImportError> {
    let scene = open(bytes)?;
    let mut warnings = Vec::new();
    let parts = meshes::parts(&scene, &mut warnings)?;
    let geometry = meshes::join(&scene, &parts, &mut warnings);
    let Joints { nodes, names, parents, binds } = joints::find(&scene, &parts)?;
    let takes = frames::takes(&scene, &nodes, &parts, sampling, &mut warnings)?;
    let posed = meshes::are_posed(&scene, &parts, &mut warnings);
    let shown = (posed && sampling.shapes).then_some(parts.as_slice());
    let Posed { joints: frames, shapes, morphs } = frames::posed(&scene, &takes, &nodes, shown)?;
    Ok(Rig {
        rest: geometry.rest,
        triangles: geometry.triangles,
        uv: geometry.uv,
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

fn open(bytes: &[u8]) -> Result<SceneRoot, ImportError> {
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

fn fault(error: ufbx::Error) -> ImportError {
    ImportError::Fbx { reason: error.description.to_lowercase() }
}

fn matrix(m: &ufbx::Matrix) -> Matrix4<f64> {
    Matrix4::new(
        m.m00, m.m01, m.m02, m.m03, m.m10, m.m11, m.m12, m.m13, m.m20, m.m21, m.m22, m.m23, 0.0,
        0.0, 0.0, 1.0,
    )
}

#[cfg(test)]
mod tests;
