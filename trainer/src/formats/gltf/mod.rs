//! glTF 2.0: skeleton, skin, clips and morph targets, as a viewer shows them.

mod accessor;
pub(super) mod appearance;
mod clips;
mod file;
mod meshes;
mod motion;
mod nodes;
pub(crate) mod rigged;
pub(crate) mod shaped;
mod skins;
mod welded;
pub(crate) mod write;

pub(crate) use motion::read_motion;

use std::path::Path;

use nalgebra::{Matrix4, Vector3};
use rayon::prelude::*;
use sinew_runtime::format::Space;

use self::clips::ClipKeys;
use self::meshes::Meshes;
use self::nodes::{Local, Nodes};
use self::skins::Skins;
use self::welded::Welded;
use super::error::FormatError;
use super::posed_meshes::PosedMeshes;
use super::scene::{Clip, SampledScene, Sampling, SceneError, sample_times};
use super::warning::FormatWarning;

/// Reads a rigged character: every mesh that has a skin, its joints, and every clip that moves them.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, FormatError> {
    let (document, buffers) = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let (mut meshes, left_out) = Meshes::read(&document, &buffers, |node| shown[node], true)?;
    if meshes.instances.is_empty() {
        let empty = document.meshes().len() == 0;
        return Err(if empty { SceneError::NoMesh } else { SceneError::NoSkin }.into());
    }
    let skins = Skins::read(&document, &buffers, &nodes, &mut meshes)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(&document, &buffers)?);
    let mut warnings = Vec::new();
    if !left_out.is_empty() {
        warnings.push(FormatWarning::UnskinnedMeshes { meshes: left_out });
    }
    let welded = Welded::new(&scene.meshes);
    if welded.repaired > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count: welded.repaired });
    }
    let mut moved = vec![false; scene.nodes.names.len()];
    for node in skins.joints.iter().flat_map(|&joint| scene.nodes.upwards(joint)) {
        moved[node] = true;
    }
    let (clips, moments) = scene.sample(&moved, sampling, &mut warnings)?;
    let posed: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            let worlds = scene.nodes.worlds(&locals);
            let joints: Vec<_> = skins.joints.iter().map(|&node| worlds[node]).collect();
            let shape = sampling.shapes.then(|| scene.skinned(&skins, &joints, &weights));
            let shape = shape.map(|shape| welded.pick(&shape));
            (joints, shape.unwrap_or_default())
        })
        .collect();
    let (frames, shapes): (Vec<_>, Vec<_>) = posed.into_iter().unzip();
    let parents = skins.parents(&scene.nodes);
    let names = skins.joints.iter().map(|&node| scene.nodes.names[node].clone()).collect();
    let morphs = moments.iter().any(|moment| moment.clip.shapes(|node| scene.shows(node)));
    let ranges = scene.meshes.ranges().into_iter();
    let ranges = ranges.map(|(name, range)| (name, welded.range(&range))).collect();
    let rest = welded.pick(&scene.meshes.positions);
    let Welded { triangles, engine, .. } = welded;
    Ok(SampledScene {
        rest,
        triangles,
        engine,
        ranges,
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

/// Reads posed meshes without joints: every mesh of the file, shaped by its morph targets and placed
/// by its node.
///
/// # Errors
/// As [`read`], but for what concerns skins.
pub(crate) fn read_posed_meshes(path: &Path) -> Result<PosedMeshes, FormatError> {
    let (document, buffers) = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let (meshes, _) = Meshes::read(&document, &buffers, |node| shown[node], false)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(&document, &buffers)?);
    if scene.meshes.instances.is_empty() {
        return Err(SceneError::NoMesh.into());
    }
    let mut moved = vec![false; scene.nodes.names.len()];
    for instance in &scene.meshes.instances {
        for node in scene.nodes.upwards(instance.node) {
            moved[node] = true;
        }
    }
    let sampling = Sampling { fps: None, clips: &[], shapes: true, still: false };
    let (_, moments) = scene.sample(&moved, &sampling, &mut Vec::new())?;
    let shapes: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            scene.placed(&scene.nodes.worlds(&locals), &weights)
        })
        .collect();
    Ok(PosedMeshes::bare(scene.meshes.positions.len(), shapes.concat()))
}

/// What a viewer of the file needs.
struct Scene {
    nodes: Nodes,
    meshes: Meshes,
    animations: Vec<ClipKeys>,
    /// What moves nothing.
    nothing: ClipKeys,
}

impl Scene {
    fn new(nodes: Nodes, meshes: Meshes, animations: Vec<ClipKeys>) -> Self {
        Self { nodes, meshes, animations, nothing: ClipKeys::default() }
    }
}

/// A time of a clip.
struct Moment<'a> {
    clip: &'a ClipKeys,
    time: f64,
}

impl Scene {
    /// Lists the clips to read, and their moments.
    fn sample(
        &self,
        moved: &[bool],
        sampling: &Sampling<'_>,
        warnings: &mut Vec<FormatWarning>,
    ) -> Result<(Vec<Clip>, Vec<Moment<'_>>), SceneError> {
        if sampling.still {
            return Ok((vec![Clip::still()], vec![Moment { clip: &self.nothing, time: 0.0 }]));
        }
        let names: Vec<String> = self.animations.iter().map(|keys| keys.name.clone()).collect();
        sampling.check(names.clone())?;
        let (mut clips, mut moments, mut idle) = (Vec::new(), Vec::new(), Vec::new());
        for keys in self.animations.iter().filter(|keys| sampling.takes(&keys.name)) {
            let times = keys.times(|node| moved[node], |node| self.shows(node));
            let times = sample_times(&keys.name, times, sampling)?;
            if times.is_empty() {
                idle.push(keys.name.clone());
                continue;
            }
            clips.push(Clip::at(keys.name.clone(), moments.len(), &times));
            moments.extend(times.into_iter().map(|time| Moment { clip: keys, time }));
        }
        if clips.is_empty() {
            return Err(SceneError::NothingMoves { clips: names });
        }
        if !idle.is_empty() {
            warnings.push(FormatWarning::IdleClips { clips: idle });
        }
        Ok((clips, moments))
    }

    /// Tells whether a node shows one of the meshes.
    fn shows(&self, node: usize) -> bool {
        self.meshes.instances.iter().any(|instance| instance.node == node)
    }

    /// Gives the nodes' transforms at a moment, and the weights of their morph targets.
    fn at(&self, moment: &Moment<'_>) -> (Vec<Local>, Vec<Vec<f64>>) {
        let mut locals = self.nodes.locals.clone();
        let mut weights = vec![Vec::new(); locals.len()];
        for instance in &self.meshes.instances {
            weights[instance.node].clone_from(&instance.weights);
        }
        moment.clip.apply(moment.time, &mut locals, &mut weights);
        (locals, weights)
    }

    /// Skins the meshes' shapes with joints at these world transforms.
    fn skinned(
        &self,
        skins: &Skins,
        joints: &[Matrix4<f64>],
        weights: &[Vec<f64>],
    ) -> Vec<[f64; 3]> {
        let maps: Vec<_> = joints
            .iter()
            .zip(&skins.inverse_binds)
            .map(|(joint, inverse)| joint * inverse)
            .collect();
        self.each(weights, |instance, vertex, shape| {
            let members = instance.skin.map(|skin| skins.members[&skin].joints.as_slice());
            let members = members.unwrap_or_default();
            let (mut sum, mut total) = (Vector3::zeros(), 0.0);
            for &(member, weight) in &self.meshes.influences[vertex] {
                sum += maps[members[member]].transform_point(&shape.into()).coords * weight;
                total += weight;
            }
            sum / total
        })
    }

    /// Places the meshes' shapes where their nodes are.
    fn placed(&self, worlds: &[Matrix4<f64>], weights: &[Vec<f64>]) -> Vec<[f64; 3]> {
        self.each(weights, |instance, _, shape| {
            worlds[instance.node].transform_point(&shape.into()).coords
        })
    }

    /// Shapes every vertex by the morph targets, and puts it where `place` says.
    fn each(
        &self,
        weights: &[Vec<f64>],
        place: impl Fn(&meshes::Instance, usize, Vector3<f64>) -> Vector3<f64>,
    ) -> Vec<[f64; 3]> {
        let mut all = Vec::with_capacity(self.meshes.positions.len());
        for (number, instance) in self.meshes.instances.iter().enumerate() {
            let active = instance.morphs.iter().zip(&weights[instance.node]);
            let active: Vec<_> = active.filter(|(_, weight)| **weight != 0.0).collect();
            for (own, vertex) in self.meshes.vertices(number).enumerate() {
                let mut shape = Vector3::from(self.meshes.positions[vertex]);
                for (morph, weight) in &active {
                    shape += Vector3::from(morph[own]) * **weight;
                }
                all.push(place(instance, vertex, shape).into());
            }
        }
        all
    }
}

#[cfg(test)]
mod tests;
