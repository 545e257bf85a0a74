//! The skins of a glTF file, joined into one skeleton, and the scene that they move in.

use super::curves::{NamedTargets, named_targets, tracks};
use super::file::{Parsed, no_such, numbers, other_count};
use super::keys::ClipKeys;
use super::meshes::{Meshes, no_skin};
use super::nodes::{Local, Nodes};
use crate::Error;
use crate::formats::FormatWarning;
use crate::formats::scene::{Clip, CurveTrack, MovingJoints, Sample, Sampling, faults, samples};
use nalgebra::{Matrix3, Matrix4, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Share of the largest entry within which two bind matrices of a joint agree; files round them.
const AGREE: f64 = 1e-4;

/// Blender's name for the joint that it adds for vertices without weights.
const NEUTRAL: &str = "neutral_bone";

/// The joints of all skins, each once.
#[derive(Default)]
pub(super) struct Skins {
    /// Node of each joint, J.
    pub(super) joints: Vec<usize>,
    /// World frame of each joint in the bind pose of the joined mesh, J.
    pub(super) binds: Vec<Matrix4<f64>>,
    /// Inverses of `binds`.
    pub(super) inverse_binds: Vec<Matrix4<f64>>,
    /// The joined skins, by their index in the file.
    pub(super) members: HashMap<usize, Member>,
}

/// A skin of the skeleton.
pub(super) struct Member {
    /// Its joints, as indices into J.
    pub(super) joints: Vec<usize>,
    /// Transform of its meshes into the space of the first skin.
    pub(super) shift: Matrix4<f64>,
}

impl Skins {
    /// Joins the skins of all meshes, and moves each mesh into the bind space of the first skin. Exporters differ in
    /// whether all skins of a character share a space.
    ///
    /// - `unbound`: whether a vertex may have no joint weight.
    ///
    /// # Errors
    /// A skin is missing, a vertex has no joint weight or names a missing joint, a bind matrix cannot be read or
    /// inverted, or two meshes bind a joint at different places.
    pub(super) fn read(file: &Parsed, meshes: &mut Meshes, unbound: bool) -> Result<Self, Error> {
        let mut all = Self::default();
        for instance in 0..meshes.instances.len() {
            let mesh = meshes.instances[instance].name.clone();
            let Some(number) = meshes.instances[instance].skin else { continue };
            let skin = file.document.skins().nth(number).ok_or_else(no_skin)?;
            let joined = all.join(&skin, file, &mesh)?;
            let influences = &meshes.influences[meshes.vertices(instance)];
            check_influences(influences, joined.joints.len(), &mesh, unbound)?;
            move_mesh(meshes, instance, &joined.shift);
        }
        Ok(all)
    }

    /// Joins all skins of a file, used by a mesh or not.
    ///
    /// # Errors
    /// Those of [`Skins::join`].
    pub(super) fn all(file: &Parsed) -> Result<Self, Error> {
        let mut all = Self::default();
        for skin in file.document.skins() {
            all.join(&skin, file, skin.name().unwrap_or("none"))?;
        }
        Ok(all)
    }

    /// Adds the joints of a skin to the skeleton, unless the skin is already joined.
    ///
    /// # Errors
    /// A bind matrix cannot be read or inverted, or another mesh binds a joint at a different place.
    pub(super) fn join(
        &mut self,
        skin: &gltf::Skin<'_>,
        file: &Parsed,
        mesh: &str,
    ) -> Result<&Member, Error> {
        if !self.members.contains_key(&skin.index()) {
            let member = self.joined(skin, file, mesh)?;
            self.members.insert(skin.index(), member);
        }
        Ok(&self.members[&skin.index()])
    }

    fn joined(
        &mut self,
        skin: &gltf::Skin<'_>,
        file: &Parsed,
        mesh: &str,
    ) -> Result<Member, Error> {
        let (joint_nodes, own) = read_one(skin, file, mesh)?;
        let known = |joints: &[usize], node| joints.iter().position(|&joint| joint == node);
        let shared = joint_nodes.iter().zip(&own).find_map(|(&node, own)| {
            known(&self.joints, node).map(|joint| self.binds[joint] * own)
        });
        let shift = shared.unwrap_or_else(Matrix4::identity);
        let mut joints = Vec::with_capacity(joint_nodes.len());
        for (&node, own) in joint_nodes.iter().zip(&own) {
            let name = file.nodes.tree.names[node].as_str();
            let singular = || faults::singular_bind(name);
            let inverse = own * shift.try_inverse().ok_or_else(singular)?;
            let joint = match known(&self.joints, node) {
                Some(joint) if !agree(&self.inverse_binds[joint], &inverse) => {
                    return Err(faults::other_bind(mesh, name));
                }
                Some(joint) => joint,
                None => {
                    self.joints.push(node);
                    self.binds.push(inverse.try_inverse().ok_or_else(singular)?);
                    self.inverse_binds.push(inverse);
                    self.joints.len() - 1
                }
            };
            joints.push(joint);
        }
        Ok(Member { joints, shift })
    }

    /// Warns of the joint that Blender adds for vertices without weights.
    pub(super) fn neutral(&self, nodes: &Nodes, meshes: &Meshes) -> Option<FormatWarning> {
        let name = |joint: usize| &nodes.tree.names[self.joints[joint]];
        let neutral = |&joint: &usize| name(joint).starts_with(NEUTRAL);
        let found = (0..self.joints.len()).find(neutral)?;
        let followers = meshes.instances.iter().enumerate().map(|(number, instance)| {
            let Some(member) = instance.skin.and_then(|skin| self.members.get(&skin)) else {
                return 0;
            };
            let follows =
                |&(joint, weight): &(usize, f64)| weight > 0.0 && neutral(&member.joints[joint]);
            let own = &meshes.influences[meshes.vertices(number)];
            own.iter().filter(|influences| influences.iter().any(follows)).count()
        });
        Some(FormatWarning::NeutralBone { joint: name(found).clone(), count: followers.sum() })
    }

    /// Returns the joint weights of some vertices (in ascending order): a row of J for each vertex.
    pub(super) fn weights_of(&self, meshes: &Meshes, vertices: &[usize]) -> Vec<f64> {
        let mut all = vec![0.0; vertices.len() * self.joints.len()];
        let rows = all.chunks_exact_mut(self.joints.len().max(1)).zip(vertices);
        for (row, &vertex) in rows {
            let after = meshes.instances.partition_point(|instance| instance.first <= vertex);
            let skin = meshes.instances[after - 1].skin;
            let Some(member) = skin.and_then(|skin| self.members.get(&skin)) else { continue };
            for &(joint, weight) in &meshes.influences[vertex] {
                row[member.joints[joint]] += weight;
            }
        }
        all
    }

    /// Returns the bind frame of each node; `None` for a node that is no joint.
    pub(super) fn binds_of_nodes(&self, nodes: &Nodes) -> Vec<Option<Matrix4<f64>>> {
        let mut binds = vec![None; nodes.locals.len()];
        for (&node, &bind) in self.joints.iter().zip(&self.binds) {
            binds[node] = Some(bind);
        }
        binds
    }
}

/// Transforms the vertices and morph targets of a mesh; a mirroring also reverses the triangles' winding and the
/// tangents' handedness.
pub(super) fn move_mesh(meshes: &mut Meshes, instance: usize, shift: &Matrix4<f64>) {
    if *shift == Matrix4::identity() {
        return;
    }
    let vertices = meshes.vertices(instance);
    for position in &mut meshes.positions[vertices.clone()] {
        *position = shift.transform_point(&(*position).into()).into();
    }
    let linear = shift.fixed_view::<3, 3>(0, 0).into_owned();
    // Normals stay orthogonal to the surface under any scale.
    let turn = normal_matrix(shift);
    for normal in &mut meshes.normals[vertices.clone()] {
        *normal = (turn * Vector3::from(*normal)).into();
    }
    for [x, y, z, _] in &mut meshes.tangents[vertices.clone()] {
        [*x, *y, *z] = (linear * Vector3::new(*x, *y, *z)).into();
    }
    if linear.determinant() < 0.0 {
        for [a, b, _] in meshes.triangles.iter_mut().filter(|[a, ..]| vertices.contains(a)) {
            std::mem::swap(a, b);
        }
        // A mirrored cross product changes the handedness.
        for [.., handedness] in &mut meshes.tangents[vertices.clone()] {
            *handedness = -*handedness;
        }
    }
    for displacement in meshes.instances[instance].morphs.iter_mut().flatten() {
        *displacement = shift.transform_vector(&(*displacement).into()).into();
    }
}

/// Returns the matrix that transforms normals under a placement.
fn normal_matrix(world: &Matrix4<f64>) -> Matrix3<f64> {
    let linear = world.fixed_view::<3, 3>(0, 0).into_owned();
    linear.try_inverse().map_or(linear, |inverse| inverse.transpose())
}

/// The nodes, meshes and animations of a file.
pub(super) struct Scene<'a> {
    pub(super) nodes: &'a Nodes,
    pub(super) meshes: Meshes,
    pub(super) animations: Vec<ClipKeys>,
    /// Morph targets whose weights are curves.
    pub(super) named: Vec<NamedTargets>,
}

/// A time of a clip; without a clip, the scene without animation.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub(super) clip: Option<&'a ClipKeys>,
    pub(super) time: f64,
}

impl<'a> Scene<'a> {
    /// Reads the animations that move some meshes.
    ///
    /// - `curves`: whether weights of named morph targets are curves.
    ///
    /// # Errors
    /// Those of [`ClipKeys::read`].
    pub(super) fn new(file: &'a Parsed, meshes: Meshes, curves: bool) -> Result<Self, Error> {
        let named = if curves { named_targets(file) } else { Vec::new() };
        Ok(Self { nodes: &file.nodes, meshes, animations: ClipKeys::read(file)?, named })
    }

    /// Lists the clips to read and their sample times, for these moving joints or other nodes.
    ///
    /// # Errors
    /// A requested clip does not exist, key times cannot be sampled, or no clip moves anything.
    pub(super) fn sample(
        &self,
        joints: &[usize],
        sampling: &Sampling<'_>,
        warnings: &mut Vec<FormatWarning>,
    ) -> Result<(Vec<Clip>, Vec<Moment<'_>>), Error> {
        if sampling.still {
            return Ok((vec![Clip::still()], vec![Moment { clip: None, time: 0.0 }]));
        }
        let names: Vec<String> = self.animations.iter().map(|keys| keys.name.clone()).collect();
        sampling.check(names.clone())?;
        let mut moved = vec![false; self.nodes.locals.len()];
        for node in joints.iter().flat_map(|&joint| self.nodes.tree.upwards(joint)) {
            moved[node] = true;
        }
        let parents = self.nodes.tree.parents_among(joints);
        let (mut clips, mut moments, mut idle) = (Vec::new(), Vec::new(), Vec::new());
        for keys in self.animations.iter().filter(|keys| sampling.takes(&keys.name)) {
            let is_named = |node| self.named.iter().any(|own| own.node == node);
            let times = keys.times(|node| moved[node], |node| self.shows(node) || is_named(node));
            let pose = |time| {
                let worlds = self.nodes.worlds(&self.at(&Moment { clip: Some(keys), time }).0);
                Ok(joints.iter().map(|&node| worlds[node]).collect())
            };
            let joints = MovingJoints { parents: &parents, frame: 0.0, pose };
            let samples = samples(&keys.name, times, sampling, &joints)?;
            if samples.is_empty() {
                idle.push(keys.name.clone());
                continue;
            }
            clips.push(Clip::sampled(keys.name.clone(), moments.len(), &samples));
            let moment = |Sample { at: time, .. }| Moment { clip: Some(keys), time };
            moments.extend(samples.into_iter().map(moment));
        }
        if clips.is_empty() {
            return Err(faults::nothing_moves(&names));
        }
        warnings.extend(FormatWarning::listed(FormatWarning::IdleClips, idle));
        Ok((clips, moments))
    }

    /// Returns whether a node shows a mesh.
    pub(super) fn shows(&self, node: usize) -> bool {
        self.meshes.instances.iter().any(|instance| instance.node == node)
    }

    /// Samples the weights of the named morph targets.
    pub(super) fn curves(&self, moments: &[Moment<'_>]) -> Vec<CurveTrack> {
        if self.named.is_empty() {
            return Vec::new();
        }
        let frames: Vec<_> = moments.par_iter().map(|moment| self.at(moment).1).collect();
        tracks(&self.named, &frames)
    }

    /// Returns the nodes' transforms at a moment, and the weights of their morph targets.
    pub(super) fn at(&self, moment: &Moment<'_>) -> (Vec<Local>, Vec<Vec<f64>>) {
        let mut locals = self.nodes.locals.clone();
        let mut weights = vec![Vec::new(); locals.len()];
        for instance in &self.meshes.instances {
            weights[instance.node].clone_from(&instance.weights);
        }
        if let Some(clip) = moment.clip {
            clip.apply(moment.time, &mut locals, &mut weights);
        }
        (locals, weights)
    }

    /// Returns the posed vertices for nodes at these world transforms; a mesh without a skin moves with its node.
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
        let mut all = Vec::with_capacity(self.meshes.positions.len());
        for (number, instance) in self.meshes.instances.iter().enumerate() {
            let more = weights[instance.node].iter().zip(&instance.weights);
            // The positions already include the default weights.
            let more = more.map(|(weight, default)| weight - default);
            let active = instance.morphs.iter().zip(more);
            let active: Vec<_> = active.filter(|(_, weight)| *weight != 0.0).collect();
            let members = instance.skin.map(|skin| &skins.members[&skin].joints);
            for (own, vertex) in self.meshes.vertices(number).enumerate() {
                let mut shape = Vector3::from(self.meshes.positions[vertex]);
                for (morph, weight) in &active {
                    shape += Vector3::from(morph[own]) * *weight;
                }
                let Some(members) = members else {
                    all.push(worlds[instance.node].transform_point(&shape.into()).into());
                    continue;
                };
                let (mut sum, mut total) = (Vector3::zeros(), 0.0);
                for &(member, weight) in &self.meshes.influences[vertex] {
                    sum += maps[members[member]].transform_point(&shape.into()).coords * weight;
                    total += weight;
                }
                all.push((sum / total).into());
            }
        }
        all
    }
}

/// Checks that every vertex has joints, unless `unbound`, and that the joints exist.
fn check_influences(
    influences: &[Vec<(usize, f64)>],
    joint_len: usize,
    mesh: &str,
    unbound: bool,
) -> Result<(), Error> {
    for (vertex, influences) in influences.iter().enumerate() {
        if influences.is_empty() && !unbound {
            return Err(Error::missing(format!(
                "mesh {mesh}: vertex {vertex} has no joint weight: assign every vertex to a joint before \
                 exporting, or give the posed meshes as --targets"
            )));
        }
        if let Some(&(joint, _)) = influences.iter().find(|(joint, _)| *joint >= joint_len) {
            return Err(no_such(format!("mesh {mesh}"), "joint", joint, joint_len));
        }
    }
    Ok(())
}

/// Reads the joints of a skin and their inverse bind matrices, which are identities if the skin has none.
fn read_one(
    skin: &gltf::Skin<'_>,
    file: &Parsed,
    mesh: &str,
) -> Result<(Vec<usize>, Vec<Matrix4<f64>>), Error> {
    let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
    let Some(accessor) = skin.inverse_bind_matrices() else {
        let own = vec![Matrix4::identity(); joints.len()];
        return Ok((joints, own));
    };
    let own = numbers(&accessor, &file.buffers, 16)?;
    let own: Vec<_> = own.chunks_exact(16).map(Matrix4::from_column_slice).collect();
    if own.len() < joints.len() {
        let (expected, found) = (joints.len(), own.len());
        let place = format!("the skin of mesh {mesh}");
        return Err(other_count(place, "inverse bind matrices", expected, found));
    }
    Ok((joints, own))
}

/// Returns whether two bind matrices agree up to rounding.
fn agree(a: &Matrix4<f64>, b: &Matrix4<f64>) -> bool {
    (a - b).amax() <= AGREE * a.amax()
}
