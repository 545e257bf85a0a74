//! Stages of the kernel predictor: joints, features and correction (METHOD §1.9).

use super::confidence;
use super::group::{ExpectedError, Group};
use super::polar::{is_hidden, polar};
use super::pose::Pose;
use super::view::{Envelope, joint_index};
use crate::linear::{
    Columns, Matrix3x4, columns, dot, floats, padded, quaternion, split, turn_back,
};
use crate::matrix;
use crate::numeric::{lesser, sqrt};
use crate::unit::{Level, level};

/// Evaluates stage joints: [`crate::stages::joints`] with checked arguments.
pub(crate) fn joints(envelope: &Envelope<'_>, pose: &[Matrix3x4], out_palette: &mut [Matrix3x4]) {
    let (joints, helpers) = split(out_palette, pose.len());
    for (out, map) in joints.iter_mut().zip(pose) {
        *out = *map;
    }
    for group in envelope.groups() {
        if let Some(out) = helpers.get_mut(group.proxies) {
            out.fill(*dominant(pose, group.joint));
        }
    }
}

/// Evaluates stages polar, if joints stretch, and features.
///
/// - `out_turns`: J rotations; empty if no joint stretches.
/// - `out_features`: [`super::EnvelopeCounts::feature_len`] values.
pub(crate) fn all_features(
    envelope: &Envelope<'_>,
    pose: Pose<'_>,
    out_turns: &mut [Columns],
    out_features: &mut [f32],
) {
    if envelope.stretches() {
        let (_, strains) = split(out_features, 12 * pose.joints.len());
        polar(envelope, pose.joints, out_turns, strains.as_chunks_mut().0);
    }
    features(envelope, pose, out_turns, out_features);
}

/// Evaluates stage features: [`crate::stages::features`] with checked arguments.
///
/// - `turns`: J rotations from stage polar; empty if no joint stretches.
/// - `out_features`: the strains, which stage polar has written, stay.
pub(crate) fn features(
    envelope: &Envelope<'_>,
    pose: Pose<'_>,
    turns: &[Columns],
    out_features: &mut [f32],
) {
    let curves = out_features.len().saturating_sub(pose.curves.len());
    let (of_joints, of_curves) = split(out_features, curves);
    for (out, value) in of_curves.iter_mut().zip(pose.curves) {
        *out = *value;
    }
    let of_joints = of_joints.as_chunks_mut::<4>().0.as_chunks_mut::<3>().0;
    let joints = envelope.parents().iter().zip(envelope.origins());
    for ((joint, out), (parent, origin)) in of_joints.iter_mut().enumerate().zip(joints) {
        let ends = |joint: usize| Some((pose.joints.get(joint)?, turn(pose.joints, turns, joint)));
        *out = match (ends(joint), joint_index(parent).and_then(ends)) {
            (Some(own), Some(parent)) if !is_hidden(own.0) && !is_hidden(parent.0) => {
                joint_features(parent, own, floats(origin))
            }
            _ => [[0.0; 4]; 3],
        };
    }
}

/// Evaluates stage correction: [`crate::stages::correction`] with checked arguments.
pub(crate) fn correction(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    features: &[f32],
    scratch: &mut [f32],
    out_palette: &mut [Matrix3x4],
) -> f32 {
    let first = out_palette.len().saturating_sub(envelope.proxy_len());
    let (_, helpers) = split(out_palette, first);
    let (mut error, level) = (ExpectedError::default(), level());
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let out = helpers.get_mut(group.proxies.clone()).unwrap_or_default();
        let dominant = dominant(pose, group.joint);
        error = error.plus(add_correction(level, &group, dominant, features, scratch, out));
    }
    #[cfg(feature = "trs")]
    super::trs::project(envelope, helpers);
    let curves = features.len().saturating_sub(envelope.curve_len());
    let curves = confidence::of_curves(envelope, features.get(curves..).unwrap_or_default());
    let joints = confidence::of_joints(envelope, pose, features);
    joints.chain(curves).fold(error.confidence(), lesser)
}

/// Computes the confidence of each joint, from the joint's range and from the groups that the joint dominates.
///
/// - `features`: from [`all_features`].
/// - `scratch`: as for [`correction`].
/// - `out_confidences`: J values.
#[inline]
pub(crate) fn joint_confidences(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    features: &[f32],
    scratch: &mut [f32],
    out_confidences: &mut [f32],
) {
    let (own, level) = (confidence::of_joints(envelope, pose, features), level());
    out_confidences.iter_mut().zip(own).for_each(|(out, own)| *out = own);
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let (error, _) = evaluate_map(level, &group, features, scratch);
        if let Some(out) = out_confidences.get_mut(group.joint) {
            *out = lesser(*out, error.confidence());
        }
    }
}

/// Returns the transform of a group's dominant joint; the identity without joints.
fn dominant(pose: &[Matrix3x4], joint: usize) -> &Matrix3x4 {
    pose.get(joint).unwrap_or(&matrix::IDENTITY)
}

/// Returns the rotation of a joint: from stage polar, or the joint's linear part if no joint stretches.
fn turn(pose: &[Matrix3x4], turns: &[Columns], joint: usize) -> Columns {
    let linear = || pose.get(joint).map(columns).map(|[x, y, z, _]| [x, y, z]);
    turns.get(joint).copied().or_else(linear).unwrap_or_default()
}

/// Returns the features of a joint, `[half R | gap]`: R is the rotation relative to the parent's, and the gap leads from
/// the joint's origin as its parent carries it to where it is, in the parent's frame.
///
/// The parent is subtracted first, so that the features are exactly 0 at rest.
///
/// - `parent`, `own`: the transform and the rotation of each.
fn joint_features(
    parent: (&Matrix3x4, Columns),
    own: (&Matrix3x4, Columns),
    origin: [f32; 3],
) -> Matrix3x4 {
    let mut gap = [[0.0; 3]];
    for (out, (own, parent)) in gap.as_flattened_mut().iter_mut().zip(own.0.iter().zip(parent.0)) {
        let [x, y, z, shift] = *own;
        let [px, py, pz, parent_shift] = *parent;
        *out = dot([x - px, y - py, z - pz], origin) + (shift - parent_shift);
    }
    turn_back(&parent.1, &mut gap);
    let mut turned = own.1;
    turn_back(&parent.1, &mut turned);
    let mut out = [[0.0; 4]; 3];
    let rows = half_rotation(&turned).into_iter().zip(gap.as_flattened());
    for (row, ([x, y, z], gap)) in out.iter_mut().zip(rows) {
        *row = [x, y, z, *gap];
    }
    out
}

/// Returns the rows of S - I. S turns by half the angle of a rotation; its odd part goes to 0 at half a turn.
///
/// `S - I = (1 - (1 - w)^8) [v] + [v][v] / (1 + w)`, with the rotation's unit quaternion w >= 0, v, and `[v]` the
/// matrix of the cross product with v.
fn half_rotation(m: &Columns) -> [[f32; 3]; 3] {
    let ([x, y, z], w) = quaternion(m);
    let length = sqrt(dot([x, y, z], [x, y, z]) + w * w);
    let low = 1.0 - w / length;
    let low = low * low;
    let low = low * low;
    let odd = (1.0 - low * low) / length;
    let even = 1.0 / (length * (length + w));
    let [a, b, c] = [x * odd, y * odd, z * odd];
    let [xx, yy, zz] = [x * x, y * y, z * z];
    let [xy, xz, yz] = [even * (x * y), even * (x * z), even * (y * z)];
    [
        [-even * (yy + zz), xy - c, xz + b],
        [xy + c, -even * (xx + zz), yz - a],
        [xz - b, yz + a, -even * (xx + yy)],
    ]
}

/// Adds a group's correction to the group's helpers, and returns the expected error.
fn add_correction(
    level: Level,
    group: &Group<'_>,
    dominant: &Matrix3x4,
    features: &[f32],
    scratch: &mut [f32],
    out: &mut [Matrix3x4],
) -> ExpectedError {
    let (error, added) = evaluate_map(level, group, features, scratch);
    let added = added.as_chunks::<4>().0.as_chunks::<3>().0;
    for (map, added) in out.iter_mut().zip(added) {
        for (row, [x, y, z, _]) in map.iter_mut().zip(dominant) {
            let [a, b, c] = added;
            for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(b).zip(c)) {
                *value += x * a + y * b + z * c;
            }
        }
    }
    error
}

/// Gathers a group's inputs and evaluates the group's map, as [`Group::evaluate`] does.
#[inline]
fn evaluate_map<'a>(
    level: Level,
    group: &Group<'_>,
    features: &[f32],
    scratch: &'a mut [f32],
) -> (ExpectedError, &'a [f32]) {
    let (input, scratch) = split(scratch, padded(group.input_len()));
    let (added, scratch) = split(scratch, padded(12 * group.proxies.len()));
    for (x, (feature, weight)) in input.iter_mut().zip(group.inputs()) {
        *x = weight * features.get(feature).copied().unwrap_or_default();
    }
    let input = input.get(..group.input_len()).unwrap_or_default();
    group.evaluate(level, input, scratch, added)
}
