//! Stages of the kernel predictor: joints, features and correction (METHOD §1.9).

use super::confidence::{self, ExpectedError};
use super::group::Group;
use super::view::{Envelope, joint_index};
use crate::linear::{
    Columns, IDENTITY, Matrix3x4, columns, dot, floats, padded, quaternion, split,
};
use crate::numeric::{lesser, sqrt};

/// Evaluates stage joints: [`crate::stages::joints`] with checked arguments.
pub(crate) fn joints(envelope: &Envelope<'_>, pose: &[Matrix3x4], out_palette: &mut [Matrix3x4]) {
    let (joints, helpers) = split(out_palette, pose.len());
    for (out, map) in joints.iter_mut().zip(pose) {
        *out = *map;
    }
    for group in envelope.groups() {
        if let (Some(out), Some(map)) = (helpers.get_mut(group.proxies), pose.get(group.joint)) {
            out.fill(*map);
        }
    }
}

/// Evaluates stage features: [`crate::stages::features`] with checked arguments.
pub(crate) fn features(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_features: &mut [Matrix3x4],
) {
    let joints = envelope.parents().iter().zip(envelope.origins());
    for ((map, out), (parent, origin)) in pose.iter().zip(out_features).zip(joints) {
        let parent = joint_index(parent).and_then(|parent| pose.get(parent));
        *out = parent.map_or([[0.0; 4]; 3], |parent| joint_features(parent, map, floats(origin)));
    }
}

/// Evaluates stage correction: [`crate::stages::correction`] with checked arguments.
pub(crate) fn correction(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    joints: &[Matrix3x4],
    scratch: &mut [f32],
    out_palette: &mut [Matrix3x4],
) -> f32 {
    let first = out_palette.len().saturating_sub(envelope.proxy_len());
    let (_, helpers) = split(out_palette, first);
    let features = joints.as_flattened().as_flattened();
    let mut error = ExpectedError::default();
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let out = helpers.get_mut(group.proxies.clone()).unwrap_or_default();
        let dominant = pose.get(group.joint).unwrap_or(&[[0.0; 4]; 3]);
        error = error.plus(add_correction(&group, dominant, features, scratch, out));
    }
    confidence::of_features(envelope.pose_ranges(), joints).fold(error.confidence(), lesser)
}

/// Computes the confidence of each joint, from the joint's range and from the groups that the joint dominates.
///
/// - `joints`: J matrices of features.
/// - `scratch`: as for [`correction`].
/// - `out_confidences`: J values.
#[inline]
pub(crate) fn joint_confidences(
    envelope: &Envelope<'_>,
    joints: &[Matrix3x4],
    scratch: &mut [f32],
    out_confidences: &mut [f32],
) {
    let own = confidence::of_features(envelope.pose_ranges(), joints);
    out_confidences.iter_mut().zip(own).for_each(|(out, own)| *out = own);
    let features = joints.as_flattened().as_flattened();
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let (error, _) = evaluate_map(&group, features, scratch);
        if let Some(out) = out_confidences.get_mut(group.joint) {
            *out = lesser(*out, error.confidence());
        }
    }
}

/// Returns the features of a joint, `[half R | (R - I) o + t]`.
///
/// The translations are subtracted first, so that the features are exactly 0 at rest.
fn joint_features(parent: &Matrix3x4, map: &Matrix3x4, origin: [f32; 3]) -> Matrix3x4 {
    let mut apart = *map;
    for (row, parent) in apart.iter_mut().zip(parent) {
        row[3] -= parent[3];
    }
    let [a, b, c] = apart;
    let mut out = [[0.0; 4]; 3];
    for (row, [x, y, z]) in out.iter_mut().zip(columns(parent)) {
        for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(&b).zip(&c)) {
            *value = x * a + y * b + z * c;
        }
    }
    let [x, y, z, _] = columns(&out);
    for ((row, half), [x, y, z]) in out.iter_mut().zip(half_rotation(&[x, y, z])).zip(IDENTITY) {
        let [rx, ry, rz, t] = *row;
        let [hx, hy, hz] = half;
        *row = [hx, hy, hz, dot([rx - x, ry - y, rz - z], origin) + t];
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
    group: &Group<'_>,
    dominant: &Matrix3x4,
    features: &[f32],
    scratch: &mut [f32],
    out: &mut [Matrix3x4],
) -> ExpectedError {
    let (error, added) = evaluate_map(group, features, scratch);
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
    group.evaluate(input, scratch, added)
}
