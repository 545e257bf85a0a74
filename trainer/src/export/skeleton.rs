//! Joints as nodes: a skeleton in its rest pose, the keys of its joints, and their times.

use nalgebra::{Isometry3, Matrix3, Matrix4, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::fmt::Display;

use crate::Error;
use crate::examples::{Clip, Matrix3x4, Skeleton};
use crate::formats::gltf::write::{ChannelKeys, Document, NodeIndex, Placed, Track, before_jumps};
use crate::numeric::so3;

/// The joints of a skeleton as nodes of a document. The nodes move and rotate. The stretch of a joint is left to
/// [`ChainNodes`](super::chains::ChainNodes) under its node, so that other joints do not inherit it.
pub(super) struct JointNodes {
    /// Nodes of the joints. A skeleton that is still adds no node; its joint is the node above.
    pub(super) nodes: Vec<NodeIndex>,
    /// Inverse bind matrices, as the file holds them.
    pub(super) inverse_binds: Vec<[[f32; 4]; 3]>,
    /// Inverses of the inverse bind matrices.
    binds: Vec<Matrix4<f64>>,
    parents: Vec<Option<usize>>,
    /// Joints in order, parents before children.
    order: Vec<usize>,
    is_still: bool,
}

/// Frame of a posed joint in the space of the palette: a rigid part, after a stretch.
pub(super) struct Frame {
    pub(super) rigid: Isometry3<f64>,
    /// Inverse of the stretch, if the joint's node has one.
    pub(super) unstretch: Option<Matrix3<f64>>,
}

/// A joint that can be the parent of further nodes.
pub(super) struct Carrier {
    /// Node of the joint.
    pub(super) node: NodeIndex,
    /// Frame of the joint in the rest pose, in the space of the palette.
    pub(super) at_rest: Isometry3<f64>,
    /// Length of the node's unit in the space of the palette.
    pub(super) unit: f64,
}

impl JointNodes {
    /// Adds the joints under a node whose space is the model's.
    pub(super) fn new(document: &mut Document, under: NodeIndex, skeleton: &Skeleton) -> Self {
        let inverse =
            |rest: &Matrix3x4| rounded(&isometry(&square(rest)).inverse().to_homogeneous());
        let parents = skeleton.own_parents();
        let mut joints = Self {
            nodes: Vec::new(),
            inverse_binds: skeleton.rest.iter().map(inverse).collect(),
            binds: Vec::new(),
            order: parents_first(&parents),
            parents,
            is_still: skeleton.is_still,
        };
        // The nodes compensate for the rounding of the inverse bind matrices. A rotation with rounded entries still has
        // an inverse.
        let bind = |rounded| wide(rounded).try_inverse().unwrap_or_else(Matrix4::identity);
        joints.binds = joints.inverse_binds.iter().map(bind).collect();
        let (at_rest, _) = joints.place(&joints.binds);
        let mut nodes = vec![under; joints.order.len()];
        let moving = joints.order.iter().filter(|_| !skeleton.is_still);
        for &joint in moving {
            let parent = joints.parents[joint].map_or(under, |parent| nodes[parent]);
            let name = skeleton.names[joint].clone();
            nodes[joint] = document.node(name, Some(parent), &at_rest[joint]);
        }
        joints.nodes = nodes;
        joints
    }

    /// Returns the joints as parents of further nodes.
    pub(super) fn carriers(&self) -> Vec<Carrier> {
        let (_, at_rest) = self.place(&self.binds);
        let carrier = |(&node, at_rest)| Carrier { node, at_rest, unit: 1.0 };
        self.nodes.iter().zip(at_rest).map(carrier).collect()
    }

    /// Makes the tracks of the joints through poses at these times. A pose has J maps from the rest pose. Also returns the
    /// world frames that the rounded keys give.
    pub(super) fn tracks(
        &self,
        poses: &[Vec<Matrix3x4>],
        times: &[f32],
    ) -> (Vec<Track>, Vec<Vec<Frame>>) {
        let keys = poses.iter().map(|pose| {
            let worlds = pose.iter().zip(&self.binds).map(|(map, bind)| square(map) * bind);
            self.place(&worlds.collect::<Vec<_>>())
        });
        let (keys, reached): (Vec<Vec<Placed>>, Vec<_>) = keys.unzip();
        let frame = |rigid| Frame { rigid, unstretch: None };
        let frames = reached.into_iter().map(|pose: Vec<_>| pose.into_iter().map(frame).collect());
        let nodes = if self.is_still { &[] } else { &self.nodes[..] };
        let scales = vec![[1.0; 3]; nodes.len()];
        (joint_tracks(nodes, &scales, &keys, times), frames.collect())
    }

    /// Places each joint relative to its parent's rounded frame, so that rounding does not accumulate along a chain.
    /// Also returns the rounded frames.
    fn place(&self, worlds: &[Matrix4<f64>]) -> (Vec<Placed>, Vec<Isometry3<f64>>) {
        let mut placed = vec![Placed::AT_PARENT; worlds.len()];
        let mut reached = vec![Isometry3::identity(); worlds.len()];
        for &joint in &self.order {
            let parent = self.parents[joint].map_or(Isometry3::identity(), |p| reached[p]);
            let local = parent.inverse() * isometry(&worlds[joint]);
            placed[joint] = Placed {
                translation: local.translation.vector.map(|x| x as f32).into(),
                rotation: quaternion(&local.rotation),
                scale: [1.0; 3],
            };
            let Placed { translation, rotation, .. } = placed[joint];
            let turned = nalgebra::Quaternion::from(rotation.map(f64::from));
            let moved = Translation3::from(Vector3::from(translation.map(f64::from)));
            let rounded = Isometry3::from_parts(moved, UnitQuaternion::from_quaternion(turned));
            reached[joint] = parent * rounded;
        }
        (placed, reached)
    }
}

pub(super) fn parents_first(parents: &[Option<usize>]) -> Vec<usize> {
    let depth = |joint: &usize| std::iter::successors(parents[*joint], |&up| parents[up]).count();
    let mut order: Vec<usize> = (0..parents.len()).collect();
    order.sort_by_key(depth);
    order
}

/// Rounds a rotation to single precision, with w not negative.
pub(super) fn quaternion(rotation: &UnitQuaternion<f64>) -> [f32; 4] {
    let sign = if rotation.w < 0.0 { -1.0 } else { 1.0 };
    (rotation.coords * sign).map(|x| x as f32).into()
}

/// Chooses the sign of each rotation that is nearest to the previous rotation.
pub(super) fn continuous(mut rotations: Vec<[f32; 4]>) -> Vec<[f32; 4]> {
    for key in 1..rotations.len() {
        let [before, here] = [rotations[key - 1], rotations[key]];
        if before.iter().zip(here).map(|(a, b)| a * b).sum::<f32>() < 0.0 {
            rotations[key] = here.map(|x| -x);
        }
    }
    rotations
}

/// Converts a rotation matrix to a quaternion.
pub(super) fn turned(matrix: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix))
}

/// Returns the nearest rigid map to a nearly rigid map.
pub(super) fn isometry(map: &Matrix4<f64>) -> Isometry3<f64> {
    let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
    let rotation = so3::polar(&linear).map_or(Matrix3::identity(), |(rotation, _)| rotation);
    let moved = Translation3::new(map[(0, 3)], map[(1, 3)], map[(2, 3)]);
    Isometry3::from_parts(moved, turned(&rotation))
}

/// Returns the rows of an affine map.
pub(super) fn rows(map: &Matrix4<f64>) -> Matrix3x4 {
    [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| map[(row, column)]))
}

/// Returns the rows of an affine map in single precision.
pub(super) fn rounded(map: &Matrix4<f64>) -> [[f32; 4]; 3] {
    rows(map).map(|row| row.map(|x| x as f32))
}

/// Widens rows in single precision to an affine map.
pub(super) fn wide(rows: &[[f32; 4]; 3]) -> Matrix4<f64> {
    square(&rows.map(|row| row.map(f64::from)))
}

pub(super) fn square([x, y, z]: &Matrix3x4) -> Matrix4<f64> {
    Matrix4::from_row_slice([*x, *y, *z, [0.0, 0.0, 0.0, 1.0]].as_flattened())
}

/// Two values count as equal within this multiple of the largest value, or of 1: the rounding of single precision.
const HELD: f32 = 4e-6;

/// Rounds the times of a clip's frames to single precision.
///
/// # Errors
/// The clip has no frames, or its times do not ascend from 0 in single precision.
pub(super) fn key_times(clip: &Clip) -> Result<Vec<f32>, Error> {
    let name = &clip.name;
    if clip.times.is_empty() {
        return Err(no_frames(format_args!("clip {name} has none")));
    }
    let times: Vec<f32> = clip.times.iter().map(|&time| time as f32).collect();
    let bad = (0..times.len()).find(|&key| {
        let after = key == 0 || times[key] > times[key - 1];
        !(after && times[key] >= 0.0 && times[key].is_finite())
    });
    let Some(frame) = bad else { return Ok(times) };
    // The frame is counted from the clip's first frame.
    let time = clip.times[frame];
    Err(Error::value(format!(
        "clip {name}: frame {frame} plays at {time} s, expected times from 0 on that ascend by more \
         than single precision rounds"
    )))
}

/// Checks that clips can be played: there is a clip, and each has frames at times that ascend from 0 in single
/// precision.
///
/// # Errors
/// There is no clip, or a clip has no frames or times that do not ascend; then the message names the clip.
pub fn check_clips(clips: &[Clip]) -> Result<(), Error> {
    times(clips).map(drop)
}

/// Returns the times of each clip in single precision.
///
/// # Errors
/// As [`check_clips`].
pub(super) fn times(clips: &[Clip]) -> Result<Vec<Vec<f32>>, Error> {
    if clips.is_empty() {
        return Err(no_frames("the examples have no clip"));
    }
    clips.iter().map(key_times).collect()
}

fn no_frames(why: impl Display) -> Error {
    Error::missing(format!("there is no frame to export: {why}"))
}

/// Makes the tracks of joints from their placements at each key. A scale has a track only if a key changes the scale
/// without animation, one of `scales`.
pub(super) fn joint_tracks(
    nodes: &[NodeIndex],
    scales: &[[f32; 3]],
    keys: &[Vec<Placed>],
    times: &[f32],
) -> Vec<Track> {
    let mut tracks = Vec::new();
    for (joint, (&node, still)) in nodes.iter().zip(scales).enumerate() {
        let translations = keys.iter().map(|pose| pose[joint].translation).collect();
        let rotations = keys.iter().map(|pose| pose[joint].rotation).collect();
        tracks.push(track(node, ChannelKeys::Translation(translations), times));
        tracks.push(track(node, ChannelKeys::Rotation(continuous(rotations)), times));
        if keys.iter().any(|pose| pose[joint].scale != *still) {
            let scales = keys.iter().map(|pose| pose[joint].scale).collect();
            tracks.push(track(node, ChannelKeys::Scale(scales), times));
        }
    }
    tracks
}

/// Makes the track of a joint. If the clip jumps, and the values are constant except at the jumps, the track has steps.
fn track(node: NodeIndex, keys: ChannelKeys, times: &[f32]) -> Track {
    let holds = match &keys {
        ChannelKeys::Translation(keys) | ChannelKeys::Scale(keys) => hold(keys, times),
        ChannelKeys::Rotation(keys) => hold(keys, times),
        ChannelKeys::Weights(keys) => hold(keys, times),
    };
    Track { node, keys, holds }
}

fn hold<const N: usize>(keys: &[[f32; N]], times: &[f32]) -> bool {
    let jumps: Vec<usize> = before_jumps(times).collect();
    let largest = keys.as_flattened().iter().fold(1.0, |most: f32, x| most.max(x.abs()));
    let is_held = |key: usize| {
        let pairs = keys[key].iter().zip(&keys[key + 1]);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) <= HELD * largest
    };
    let is_jump = |key: &usize| jumps.binary_search(key).is_ok();
    !jumps.is_empty() && (1..keys.len()).map(|key| key - 1).filter(|k| !is_jump(k)).all(is_held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_that_moves_only_at_jumps_has_steps() {
        let before = 1.0_f32.next_down();
        let times = [0.0, before, 1.0, 2.0];
        let holds = |values: [f32; 4], times: &[f32]| {
            let keys = values.map(|x| [x, 5.0, 0.0]).to_vec();
            track(0, ChannelKeys::Translation(keys), times).holds
        };
        assert!(holds([1.0, 1.0, 3.0, 3.0], &times));
        // Rounding is tolerated.
        assert!(holds([1.0, 1.000_001, 3.0, 3.0], &times));
        assert!(!holds([1.0, 1.0, 3.0, 3.1], &times));
        assert!(!holds([1.0, 1.1, 3.0, 3.0], &times));
        // Without a jump a joint at rest is linear, like all joints.
        assert!(!holds([1.0; 4], &[0.0, 0.5, 1.0, 2.0]));
    }
}
