//! The motion of joints alone: of a scene with or without a mesh.

use super::clips::ClipKeys;
use super::file::{self, Parsed};
use super::meshes::{Meshes, Wanted};
use super::nodes::Nodes;
use super::viewed::Scene;
use crate::formats::error::FormatError;
use crate::formats::scene::{Motion, Sampling};
use sinew_runtime::format::Space;
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
    let parsed = file::open(path)?;
    let Parsed { document, buffers, .. } = &parsed;
    let nodes = Nodes::read(document)?;
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let meshes = Meshes::read(document, buffers, |_| false, wanted)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(document, buffers)?);
    let names = &scene.nodes.names;
    let found: Vec<usize> =
        (0..names.len()).filter(|&node| joints.contains(&names[node])).collect();
    let mut moved = vec![false; names.len()];
    found.iter().flat_map(|&node| scene.nodes.upwards(node)).for_each(|node| moved[node] = true);
    let mut warnings = Vec::from_iter(parsed.warning());
    let (clips, moments) = scene.sample(&moved, sampling, &mut warnings)?;
    let at_rest = scene.nodes.worlds(&scene.nodes.locals);
    let frames = moments.iter().flat_map(|moment| {
        let worlds = scene.nodes.worlds(&scene.at(moment).0);
        found.iter().map(|&node| worlds[node]).collect::<Vec<_>>()
    });
    Ok(Motion {
        space: Space::GLTF,
        names: found.iter().map(|&node| names[node].clone()).collect(),
        rest: found.iter().map(|&node| at_rest[node]).collect(),
        frames: frames.collect(),
        clips,
        warnings,
    })
}
