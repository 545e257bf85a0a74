//! Confidence in a pose from the trained ranges of joints and curves, as in stage confidence (METHOD §1.8).

use super::counts::STRAIN_LEN;
use super::polar::is_hidden;
use super::view::Envelope;
use crate::linear::{Le, Matrix3x4, dot};
use crate::numeric::{greater, lesser, smoothstep, sqrt};

/// Computes the confidence of a rotational envelope: [`crate::stages::confidence`] with checked arguments.
///
/// - `pose`: J skinning matrices.
/// - `rotations`: J rotation vectors.
/// - `strains`: J strains; empty if no joint stretches.
pub(crate) fn of_rotations(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    rotations: &[[f32; 3]],
    strains: &[[f32; STRAIN_LEN]],
) -> f32 {
    if pose.iter().any(is_hidden) {
        return 0.0;
    }
    let angles = rotations.iter().map(|theta| sqrt(dot(*theta, *theta)));
    let ranges = floats(envelope.pose_ranges());
    let angles = angles.zip(ranges).map(|(angle, range)| within(angle, range, range));
    angles.chain(of_strains(envelope, strains)).fold(1.0, lesser)
}

/// Computes the confidence of each joint from its ranges alone, for an envelope with kernel maps.
///
/// The confidence falls only beyond 1.5 times the range: nearer, the kernel maps know more than the ranges. A joint
/// that never moved in training is no input of any map, so only its range tells about the joint.
///
/// - `pose`: J skinning matrices.
/// - `features`: of the pose. The trace of a joint's matrix is -2 (1 - cos(angle / 2)); the angle is approximated by
///   4 sin(angle / 4).
pub(crate) fn of_joints<'a>(
    envelope: &'a Envelope<'_>,
    pose: &'a [Matrix3x4],
    features: &'a [f32],
) -> impl Iterator<Item = f32> + 'a {
    let (joints, rest) = features.split_at(features.len().min(12 * pose.len()));
    let joints = joints.as_chunks::<4>().0.as_chunks::<3>().0;
    let angles = joints.iter().zip(floats(envelope.pose_ranges())).map(|([x, y, z], range)| {
        let angle = 2.0 * sqrt(greater(0.0, -(x[0] + y[1] + z[2])));
        within(angle, 1.5 * range, range)
    });
    let strains = if envelope.stretches() { rest.as_chunks().0 } else { &[] };
    let mut strains = of_strains(envelope, strains);
    angles
        .zip(shown(pose))
        .map(move |(angle, shown)| lesser(lesser(angle, shown), strains.next().unwrap_or(1.0)))
}

/// Computes the confidence of each curve from its range.
pub(crate) fn of_curves<'a>(
    envelope: &Envelope<'a>,
    curves: &'a [f32],
) -> impl Iterator<Item = f32> + use<'a> {
    curves.iter().zip(envelope.curve_ranges()).map(|(value, range)| {
        let [least, most] = range.map(f32::from_le_bytes);
        let half = 0.5 * (most - least);
        within((value - (least + half)).abs(), 1.5 * half, half)
    })
}

/// Computes the confidence of each joint from its strain.
fn of_strains<'a>(
    envelope: &'a Envelope<'_>,
    strains: &'a [[f32; STRAIN_LEN]],
) -> impl Iterator<Item = f32> + 'a {
    strains
        .iter()
        .zip(floats(envelope.stretch_ranges()))
        .map(|(strain, range)| within(norm(strain), 1.5 * range, range))
}

/// Returns the Frobenius norm of a strain. Entries off the diagonal count twice.
pub(crate) fn norm(&[xx, xy, xz, yy, yz, zz]: &[f32; STRAIN_LEN]) -> f32 {
    sqrt(dot([xx, yy, zz], [xx, yy, zz]) + 2.0 * dot([xy, xz, yz], [xy, xz, yz]))
}

/// Returns 0 for each hidden joint, 1 for the others.
fn shown(pose: &[Matrix3x4]) -> impl Iterator<Item = f32> {
    pose.iter().map(|map| if is_hidden(map) { 0.0 } else { 1.0 })
}

fn floats<'a>(ranges: &'a [[Le; 1]]) -> impl Iterator<Item = f32> + use<'a> {
    ranges.iter().map(|[range]| f32::from_le_bytes(*range))
}

/// Returns 1 for an angle up to `most`, and 0 from half of `range` and 0.1 beyond `most` on.
fn within(angle: f32, most: f32, range: f32) -> f32 {
    let excess = greater(angle - most, 0.0) / (0.5 * range + 0.1);
    1.0 - smoothstep(lesser(excess, 1.0))
}
