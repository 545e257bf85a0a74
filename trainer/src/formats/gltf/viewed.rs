//! A scene as a viewer shows it, moment by moment.

use super::clips::ClipKeys;
use super::meshes::{Instance, Meshes};
use super::nodes::{Local, Nodes};
use super::skins::Skins;
use crate::formats::scene::{Clip, MovingJoints, Sample, Sampling, SceneError, samples};
use crate::formats::warning::FormatWarning;
use nalgebra::{Matrix4, Vector3};

/// What a viewer of the file needs.
pub(super) struct Scene {
    pub(super) nodes: Nodes,
    pub(super) meshes: Meshes,
    pub(super) animations: Vec<ClipKeys>,
    /// What moves nothing.
    pub(super) nothing: ClipKeys,
}

impl Scene {
    pub(super) fn new(nodes: Nodes, meshes: Meshes, animations: Vec<ClipKeys>) -> Self {
        Self { nodes, meshes, animations, nothing: ClipKeys::default() }
    }
}

/// A time of a clip.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub(super) clip: &'a ClipKeys,
    pub(super) time: f64,
}

impl Scene {
    /// Lists the clips to read, and their moments, for these joints or other nodes that move.
    pub(super) fn sample(
        &self,
        joints: &[usize],
        sampling: &Sampling<'_>,
        warnings: &mut Vec<FormatWarning>,
    ) -> Result<(Vec<Clip>, Vec<Moment<'_>>), SceneError> {
        if sampling.still {
            return Ok((vec![Clip::still()], vec![Moment { clip: &self.nothing, time: 0.0 }]));
        }
        let names: Vec<String> = self.animations.iter().map(|keys| keys.name.clone()).collect();
        sampling.check(names.clone())?;
        let mut moved = vec![false; self.nodes.names.len()];
        for node in joints.iter().flat_map(|&joint| self.nodes.upwards(joint)) {
            moved[node] = true;
        }
        let parents = self.nodes.parents_among(joints);
        let (mut clips, mut moments, mut idle) = (Vec::new(), Vec::new(), Vec::new());
        for keys in self.animations.iter().filter(|keys| sampling.takes(&keys.name)) {
            let times = keys.times(|node| moved[node], |node| self.shows(node));
            let pose = |time| {
                let worlds = self.nodes.worlds(&self.at(&Moment { clip: keys, time }).0);
                Ok(joints.iter().map(|&node| worlds[node]).collect())
            };
            let joints = MovingJoints { parents: &parents, frame: 0.0, pose };
            let samples = samples(&keys.name, times, sampling, &joints)?;
            if samples.is_empty() {
                idle.push(keys.name.clone());
                continue;
            }
            let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
            clips.push(Clip::at(keys.name.clone(), moments.len(), &times));
            let moment = |Sample { at: time, .. }| Moment { clip: keys, time };
            moments.extend(samples.into_iter().map(moment));
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
    pub(super) fn shows(&self, node: usize) -> bool {
        self.meshes.instances.iter().any(|instance| instance.node == node)
    }

    /// Gives the nodes' transforms at a moment, and the weights of their morph targets.
    pub(super) fn at(&self, moment: &Moment<'_>) -> (Vec<Local>, Vec<Vec<f64>>) {
        let mut locals = self.nodes.locals.clone();
        let mut weights = vec![Vec::new(); locals.len()];
        for instance in &self.meshes.instances {
            weights[instance.node].clone_from(&instance.weights);
        }
        moment.clip.apply(moment.time, &mut locals, &mut weights);
        (locals, weights)
    }

    /// Skins the meshes' shapes with nodes at these world transforms; one without a skin goes with its node.
    pub(super) fn skinned(
        &self,
        skins: &Skins,
        worlds: &[Matrix4<f64>],
        weights: &[Vec<f64>],
    ) -> Vec<[f64; 3]> {
        let maps: Vec<_> = skins
            .joints
            .iter()
            .zip(&skins.inverse_binds)
            .map(|(&joint, inverse)| worlds[joint] * inverse)
            .collect();
        self.each(weights, |instance, vertex, shape| {
            let Some(skin) = instance.skin else {
                return worlds[instance.node].transform_point(&shape.into()).coords;
            };
            let members = &skins.members[&skin].joints;
            let (mut sum, mut total) = (Vector3::zeros(), 0.0);
            for &(member, weight) in &self.meshes.influences[vertex] {
                sum += maps[members[member]].transform_point(&shape.into()).coords * weight;
                total += weight;
            }
            sum / total
        })
    }

    /// Shapes every vertex by the morph targets, and puts it where `place` says.
    fn each(
        &self,
        weights: &[Vec<f64>],
        place: impl Fn(&Instance, usize, Vector3<f64>) -> Vector3<f64>,
    ) -> Vec<[f64; 3]> {
        let mut all = Vec::with_capacity(self.meshes.positions.len());
        for (number, instance) in self.meshes.instances.iter().enumerate() {
            let more = weights[instance.node].iter().zip(&instance.weights);
            // The positions have the default weights.
            let more = more.map(|(weight, default)| weight - default);
            let active = instance.morphs.iter().zip(more);
            let active: Vec<_> = active.filter(|(_, weight)| *weight != 0.0).collect();
            for (own, vertex) in self.meshes.vertices(number).enumerate() {
                let mut shape = Vector3::from(self.meshes.positions[vertex]);
                for (morph, weight) in &active {
                    shape += Vector3::from(morph[own]) * *weight;
                }
                all.push(place(instance, vertex, shape).into());
            }
        }
        all
    }
}
