//! glTF 2.0: skeleton, skin, clips and morph targets, as a viewer shows them.

mod accessor;
pub(super) mod appearance;
mod bare;
mod clips;
mod file;
mod meshes;
mod motion;
mod nodes;
pub(crate) mod rigged;
pub(crate) mod shaped;
mod skins;
mod triangles;
mod viewed;
mod welded;
pub(crate) mod write;

pub(super) use bare::read_mesh;
pub(crate) use motion::read_motion;

use std::path::Path;

use rayon::prelude::*;
use sinew_runtime::format::Space;

use self::clips::ClipKeys;
use self::file::Parsed;
use self::meshes::{Meshes, Wanted};
use self::nodes::Nodes;
use self::skins::Skins;
use self::viewed::Scene;
use self::welded::Welded;
use super::error::FormatError;
use super::posed_meshes::{Part, PosedMeshes};
use super::scene::{SampledScene, Sampling, SceneError};
use super::warning::FormatWarning;

/// Reads a rigged character: every mesh that has a skin, its joints, and every clip that moves them.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, FormatError> {
    let parsed = file::open(path)?;
    let Parsed { document, buffers, .. } = &parsed;
    let nodes = Nodes::read(document)?;
    let shown = nodes.shown(document);
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let mut meshes = Meshes::read(document, buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        return Err(match meshes.unskinned.is_empty() {
            _ if !shown.contains(&true) => SceneError::Empty,
            true => SceneError::NoMesh,
            false => SceneError::NoSkin,
        }
        .into());
    }
    let skins = Skins::read(document, buffers, &nodes, &mut meshes, !sampling.shapes)?;
    let mut warnings = Vec::from_iter(skins.neutral(&nodes, &meshes));
    warnings.extend(meshes.warnings().chain(parsed.warning()));
    let scene = Scene::new(nodes, meshes, ClipKeys::read(document, buffers)?);
    let welded = Welded::new(&scene.meshes);
    if welded.repaired > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count: welded.repaired });
    }
    let (names, equal) = skins.names(&scene.nodes);
    warnings.extend(equal);
    let (clips, moments) = scene.sample(&skins.joints, sampling, &mut warnings)?;
    let posed: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            let worlds = scene.nodes.worlds(&locals);
            let joints: Vec<_> = skins.joints.iter().map(|&node| worlds[node]).collect();
            let shape = sampling.shapes.then(|| scene.skinned(&skins, &worlds, &weights));
            let shape = shape.map(|shape| welded.pick(&shape));
            (joints, shape.unwrap_or_default())
        })
        .collect();
    let (frames, shapes): (Vec<_>, Vec<_>) = posed.into_iter().unzip();
    let parents = scene.nodes.parents_among(&skins.joints);
    let names = skins.joints.iter().map(|&node| names[node].clone()).collect();
    let morphs = moments.iter().any(|moment| moment.clip.shapes(|node| scene.shows(node)));
    let ranges = scene.meshes.ranges().into_iter();
    let ranges = ranges.map(|(name, range)| (name, welded.range(&range))).collect();
    let joint_weights = skins.weights_of(&scene.meshes, &welded.firsts);
    let rest = welded.pick(&scene.meshes.positions);
    let Welded { triangles, engine, .. } = welded;
    Ok(SampledScene {
        rest,
        triangles,
        engine,
        ranges,
        joint_weights: Some(joint_weights),
        space: Space::GLTF,
        names,
        parents,
        binds: skins.binds,
        frames: frames.concat(),
        shapes: sampling.shapes.then(|| shapes.concat()),
        morphs,
        clips,
        warnings,
    })
}

/// Reads posed meshes without joints: every mesh of the file, shaped by its morph targets, and carried by the joints of
/// its skin or, without one, by its node.
///
/// # Errors
/// As [`read`], but for meshes without a skin; [`SceneError::StillShapes`] where no morph target plays and nothing is
/// skinned.
pub(crate) fn read_posed_meshes(path: &Path) -> Result<PosedMeshes, FormatError> {
    let Parsed { document, buffers, .. } = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let wanted = Wanted { skinned_only: false, default_shape: true };
    let mut meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { SceneError::Empty } else { SceneError::NoMesh }.into());
    }
    let skins = Skins::read(&document, &buffers, &nodes, &mut meshes, false)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(&document, &buffers)?);
    let plays = scene.animations.iter().any(|clip| clip.shapes(|node| scene.shows(node)));
    if !plays && skins.joints.is_empty() {
        return Err(SceneError::StillShapes.into());
    }
    let instances = &scene.meshes.instances;
    let unskinned = instances.iter().filter(|instance| instance.skin.is_none());
    let moving = skins.joints.iter().copied().chain(unskinned.map(|instance| instance.node));
    let moving: Vec<usize> = moving.collect();
    let sampling = Sampling { fps: None, clips: &[], shapes: true, still: false, played: false };
    let (_, moments) = scene.sample(&moving, &sampling, &mut Vec::new())?;
    let shapes: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            scene.skinned(&skins, &scene.nodes.worlds(&locals), &weights)
        })
        .collect();
    let parts = instances.iter().enumerate().map(|(number, instance)| Part {
        names: vec![instance.name.clone()],
        range: scene.meshes.vertices(number),
    });
    Ok(PosedMeshes {
        parts: parts.collect(),
        reference: Some(scene.meshes.positions.clone()),
        ..PosedMeshes::bare(scene.meshes.positions.len(), shapes.concat())
    })
}

#[cfg(test)]
mod tests;
