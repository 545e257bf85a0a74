//! The model's joints among the nodes of an artist's file.

use nalgebra::{Isometry3, Matrix3, Matrix4, UnitQuaternion, Vector3};
use serde_json::Value;

use super::find::Found;
use crate::Error;
use crate::examples::{Matrix3x4, RIGID};
use crate::export::played::Played;
use crate::export::skeleton::{
    Carrier, Frame, isometry, joint_tracks, parents_first, quaternion, square,
};
use crate::formats::gltf::rigged::RiggedFile;
use crate::formats::gltf::write::{Document, NodeIndex, Placed, Track};
use crate::formats::scene::{JointNames, mismatch};

/// Relative difference below which a scale equals that of its node.
const SAME_SCALE: f64 = 1e-5;
/// Largest difference of a node's transform from a rotation and an even scale, relative to the scale.
const EVEN: f64 = 1e-3;

/// Frames of the joints in the model, for each pose.
type Frames = Vec<Vec<Frame>>;

/// The joints as nodes: the file's nodes where it has them, and added nodes.
pub(super) struct OwnJoints {
    /// Nodes of the joints.
    pub(super) nodes: Vec<NodeIndex>,
    /// Names of the added joints.
    pub(super) added: Vec<String>,
    /// Frames of the joints in the model's rest pose.
    frames: Vec<Isometry3<f64>>,
    /// Length of each node's unit in the model.
    pub(super) units: Vec<f64>,
    /// Scale of each node without animation.
    scales: Vec<[f32; 3]>,
    names: Vec<String>,
    /// Whether each joint stretches at a key.
    stretching: Vec<bool>,
    to_world: Matrix4<f64>,
    /// Parents of all nodes.
    parents: Vec<Option<usize>>,
    /// Transforms of all nodes at rest.
    locals: Vec<Matrix4<f64>>,
    /// All nodes in order, parents before children.
    order: Vec<usize>,
}

/// Finds the node of each joint by name. If several nodes have the name, the joint of a skin is taken.
///
/// - `joints`: names of the joints.
/// - `names`: conversion of the file's names.
///
/// # Errors
/// No joint is found, but other names would match.
pub(super) fn nodes(
    file: &RiggedFile,
    joints: &[String],
    names: &JointNames<'_>,
) -> Result<Vec<Option<NodeIndex>>, Error> {
    let own: Vec<String> = file.names.iter().map(|name| names.renamed(name, joints)).collect();
    let find = |joint: &String| {
        let mut named = (0..own.len()).filter(|&node| own[node] == *joint);
        let bound = named.clone().find(|&node| file.binds[node].is_some());
        let shows = |node: &usize| file.meshes.iter().any(|mesh| mesh.node == *node);
        bound.or_else(|| named.find(|node| !shows(node)))
    };
    let found: Vec<_> = joints.iter().map(find).collect();
    match mismatch(joints, &own).filter(|_| found.iter().all(Option::is_none)) {
        Some(mismatch) => Err(Error::missing(format!(
            "no node has the name of one of the model's joints: {}; {mismatch}",
            joints.join(", ")
        ))),
        None => Ok(found),
    }
}

impl OwnJoints {
    /// Finds the joints of the model's skeleton, and adds missing joints under their parents.
    ///
    /// # Errors
    /// Nodes above a joint scale it unevenly.
    pub(super) fn new(
        document: &mut Document,
        file: &RiggedFile,
        found: &Found,
        played: &Played<'_>,
        known: &[Option<NodeIndex>],
    ) -> Result<Self, Error> {
        let skeleton = &played.skeleton;
        let worlds = file.worlds();
        let from_world = found.at_rest.try_inverse().unwrap_or_else(Matrix4::identity);
        let len = known.len();
        let mut joints = Self {
            nodes: vec![0; len],
            added: Vec::new(),
            frames: vec![Isometry3::identity(); len],
            units: vec![1.0; len],
            scales: vec![[1.0; 3]; len],
            names: skeleton.names.clone(),
            stretching: played.stretching.clone(),
            to_world: found.to_world,
            parents: file.parents.clone(),
            locals: file.locals.clone(),
            order: file.order.clone(),
        };
        let world_unit = scale(&joints.to_world);
        for joint in parents_first(&skeleton.parents) {
            if let Some(node) = known[joint] {
                let bind = file.binds[node].unwrap_or_else(|| from_world * worlds[node]);
                let frame = found.to_model * bind;
                joints.nodes[joint] = node;
                if !scale(&frame).is_normal() {
                    return Err(joints.uneven(joint));
                }
                joints.units[joint] = scale(&frame);
                joints.frames[joint] = isometry(&(frame * even(1.0 / scale(&frame))));
                part_matrix(&mut document.nodes[node], &joints.locals[node])
                    .ok_or_else(|| joints.uneven(joint))?;
                joints.scales[joint] = stated_scale(&document.nodes[node]);
                continue;
            }
            let parent = skeleton.parents[joint];
            joints.units[joint] = parent.map_or(1.0 / world_unit, |parent| joints.units[parent]);
            joints.frames[joint] = isometry(&square(&skeleton.rest[joint]));
            let parent = parent.map(|parent| joints.nodes[parent]);
            // The transform is set below, when the parent's is known.
            let name = skeleton.names[joint].clone();
            joints.nodes[joint] = document.node(name.clone(), parent, &Placed::AT_PARENT);
            joints.order.push(joints.parents.len());
            joints.parents.push(parent);
            joints.locals.push(Matrix4::identity());
            joints.added.push(name);
        }
        let still = vec![Matrix4::identity(); len];
        let rest = joints.place(&still)?.0;
        for (joint, &node) in joints.nodes.iter().enumerate() {
            if known[joint].is_none() {
                rest[joint].state(&mut document.nodes[node]);
                joints.locals[node] = local(&rest[joint]);
                joints.scales[joint] = rest[joint].scale;
            }
        }
        Ok(joints)
    }

    /// Returns the joints as parents of proxies.
    pub(super) fn carriers(&self) -> Vec<Carrier> {
        let parts = self.nodes.iter().zip(&self.frames).zip(&self.units);
        parts.map(|((&node, &at_rest), &unit)| Carrier { node, at_rest, unit }).collect()
    }

    /// Returns the map from the model's rest mesh to a joint's space.
    pub(super) fn inverse_bind(&self, joint: usize) -> Matrix4<f64> {
        even(1.0 / self.units[joint]) * self.frames[joint].inverse().to_homogeneous()
    }

    /// Makes the tracks of the joints through poses at these times. A pose has J maps from the rest pose. Also returns
    /// the frames in the model that the rounded keys give.
    ///
    /// # Errors
    /// Nodes above a joint scale it unevenly, or the joint is sheared relative to its parent.
    pub(super) fn tracks(
        &self,
        poses: &[Vec<Matrix3x4>],
        times: &[f32],
    ) -> Result<(Vec<Track>, Frames), Error> {
        let keys = poses.iter().zip(times).map(|(pose, time)| {
            let maps: Vec<_> = pose.iter().map(square).collect();
            self.place(&maps).map_err(|error| error.within(format_args!("at {time} s")))
        });
        let keys = keys.collect::<Result<Vec<_>, _>>()?;
        let (keys, reached): (Vec<Vec<Placed>>, Vec<_>) = keys.into_iter().unzip();
        Ok((joint_tracks(&self.nodes, &self.scales, &keys, times), reached))
    }

    /// Places each joint relative to its parent's rounded transform, so that rounding does not accumulate along a
    /// chain. Also returns the rounded frames in the model.
    fn place(&self, maps: &[Matrix4<f64>]) -> Result<(Vec<Placed>, Vec<Frame>), Error> {
        let mut joint_of = vec![None; self.locals.len()];
        for (joint, &node) in self.nodes.iter().enumerate() {
            joint_of[node] = Some(joint);
        }
        let from_world = self.to_world.try_inverse().unwrap_or_else(Matrix4::identity);
        let mut placed = vec![Placed::AT_PARENT; self.nodes.len()];
        let still = || Frame { rigid: Isometry3::identity(), unstretch: None };
        let mut reached: Vec<_> = self.nodes.iter().map(|_| still()).collect();
        let mut worlds = vec![Matrix4::identity(); self.locals.len()];
        for &node in &self.order {
            let above = self.parents[node].map_or(Matrix4::identity(), |up| worlds[up]);
            let Some(joint) = joint_of[node] else {
                worlds[node] = above * self.locals[node];
                continue;
            };
            let uneven = || self.uneven(joint);
            let frame = self.frames[joint].to_homogeneous() * even(self.units[joint]);
            let target = self.to_world * maps[joint] * frame;
            let wanted = above.try_inverse().ok_or_else(uneven)? * target;
            let factor = scale(&wanted);
            let own = self.scales[joint];
            let is_own = |factors: &[f64; 3]| {
                let ratios = own.iter().zip(factors).map(|(&own, factor)| f64::from(own) / factor);
                ratios.map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max) < SAME_SCALE
            };
            let with = |factors: [f64; 3]| Placed {
                translation: wanted.fixed_view::<3, 1>(0, 3).map(|x| x as f32).into(),
                rotation: quaternion(
                    &isometry(&(wanted * along(factors.map(f64::recip)))).rotation,
                ),
                scale: if is_own(&factors) { own } else { factors.map(|factor| factor as f32) },
            };
            let off = |placed: &Placed| {
                (local(placed) - wanted).fixed_view::<3, 3>(0, 0).amax() / factor.abs()
            };
            placed[joint] = with([factor; 3]);
            if off(&placed[joint]) > RIGID {
                // The joint stretches relative to its parent.
                placed[joint] = with(factors(&wanted));
            }
            if off(&placed[joint]) > EVEN {
                return Err(if self.stretching.contains(&true) {
                    self.sheared(joint)
                } else {
                    uneven()
                });
            }
            let rounded = local(&placed[joint]);
            worlds[node] = above * rounded;
            let frame = from_world * worlds[node] * even(1.0 / self.units[joint]);
            let rigid = isometry(&frame);
            let stretch = rigid.rotation.inverse().to_rotation_matrix() * linear(&frame);
            let unstretch = stretch.try_inverse().filter(|_| self.stretching[joint]);
            reached[joint] = Frame { rigid, unstretch };
        }
        Ok((placed, reached))
    }

    fn sheared(&self, joint: usize) -> Error {
        Error::unsupported(format!(
            "joint {} is sheared relative to its parent, which a node of the file cannot hold: export without \
             --into, or key the joints so that none shears",
            self.names[joint]
        ))
    }

    fn uneven(&self, joint: usize) -> Error {
        Error::unsupported(format!(
            "joint {} hangs under nodes that scale unevenly: apply the scale of the armature before \
             exporting",
            self.names[joint]
        ))
    }
}

/// Splits a node's matrix into translation, rotation and scale, which keys can animate; `None` if the matrix has other
/// parts.
fn part_matrix(node: &mut Value, matrix: &Matrix4<f64>) -> Option<()> {
    if node.get("matrix").is_none() {
        return Some(());
    }
    let scale = factors(matrix);
    if scale.iter().any(|factor| !factor.is_normal()) {
        return None;
    }
    let linear =
        matrix.fixed_view::<3, 3>(0, 0) * Matrix3::from_diagonal(&scale.map(f64::recip).into());
    let turn = isometry(&linear.to_homogeneous()).rotation;
    let placed = Placed {
        translation: matrix.fixed_view::<3, 1>(0, 3).map(|x| x as f32).into(),
        rotation: quaternion(&turn),
        scale: scale.map(|x| x as f32),
    };
    let even = (turn.to_rotation_matrix().into_inner() - linear).amax() <= EVEN;
    node.as_object_mut()?.remove("matrix");
    placed.state(node);
    even.then_some(())
}

/// Reads the scale that a node states.
fn stated_scale(node: &Value) -> [f32; 3] {
    let factor = |axis: usize| node.get("scale").and_then(|scale| scale.get(axis)?.as_f64());
    [0, 1, 2].map(|axis| factor(axis).map_or(1.0, |factor| factor as f32))
}

/// Returns a matrix's scale along its axes; negative along all axes if the matrix mirrors.
fn factors(local: &Matrix4<f64>) -> [f64; 3] {
    let linear = local.fixed_view::<3, 3>(0, 0);
    let sign = linear.determinant().signum();
    [0, 1, 2].map(|axis| sign * linear.column(axis).norm())
}

fn scale(map: &Matrix4<f64>) -> f64 {
    map.fixed_view::<3, 3>(0, 0).determinant().cbrt()
}

fn even(scale: f64) -> Matrix4<f64> {
    along([scale; 3])
}

fn along(scales: [f64; 3]) -> Matrix4<f64> {
    Matrix3::from_diagonal(&scales.into()).to_homogeneous()
}

fn linear(map: &Matrix4<f64>) -> Matrix3<f64> {
    map.fixed_view::<3, 3>(0, 0).into_owned()
}

fn local(placed: &Placed) -> Matrix4<f64> {
    let [moved, factors] =
        [placed.translation, placed.scale].map(|x| Vector3::from(x.map(f64::from)));
    let turned = UnitQuaternion::from_quaternion(placed.rotation.map(f64::from).into());
    let linear = turned.to_rotation_matrix() * Matrix3::from_diagonal(&factors);
    let mut local = linear.to_homogeneous();
    local.fixed_view_mut::<3, 1>(0, 3).copy_from(&moved);
    local
}
