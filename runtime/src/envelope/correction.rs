//! Stage correction: what the kernel maps add to the palette (METHOD §1.9).

use super::confidence;
use super::group::Group;
use super::trust::Evidence;
use super::view::Envelope;
use crate::linear::{Matrix3x4, padded, split};
use crate::numeric::lesser;

/// Evaluates the stage: [`crate::stages::correction`] of arguments that have been checked.
pub(crate) fn evaluate(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    joints: &[Matrix3x4],
    scratch: &mut [f32],
    out_palette: &mut [Matrix3x4],
) -> f32 {
    let first = out_palette.len().saturating_sub(envelope.proxy_len());
    let (_, proxies) = split(out_palette, first);
    let features = joints.as_flattened().as_flattened();
    let mut evidence = Evidence::default();
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let out = proxies.get_mut(group.proxies.clone()).unwrap_or_default();
        let dominant = pose.get(group.joint).unwrap_or(&[[0.0; 4]; 3]);
        evidence = evidence.and(add(&group, dominant, features, scratch, out));
    }
    confidence::of_features(envelope, joints).fold(evidence.confidence(), lesser)
}

/// Evaluates how confident the groups are, by their joints, and what is known of each joint's angle: J values, of arguments
/// that have been checked.
#[inline]
pub(crate) fn joint_confidences(
    envelope: &Envelope<'_>,
    joints: &[Matrix3x4],
    scratch: &mut [f32],
    out_confidences: &mut [f32],
) {
    let own = confidence::of_features(envelope, joints);
    out_confidences.iter_mut().zip(own).for_each(|(out, own)| *out = own);
    let features = joints.as_flattened().as_flattened();
    for group in envelope.groups().filter(|group| group.centre_len() > 0) {
        let (evidence, _) = evaluate_map(&group, features, scratch);
        if let Some(out) = out_confidences.get_mut(group.joint) {
            *out = lesser(*out, evidence.confidence());
        }
    }
}

/// Adds a group's correction to its proxies, and returns what it knows.
fn add(
    group: &Group<'_>,
    dominant: &Matrix3x4,
    features: &[f32],
    scratch: &mut [f32],
    out: &mut [Matrix3x4],
) -> Evidence {
    let (evidence, added) = evaluate_map(group, features, scratch);
    let added = added.as_chunks::<4>().0.as_chunks::<3>().0;
    for (map, added) in out.iter_mut().zip(added) {
        for (row, [x, y, z, _]) in map.iter_mut().zip(dominant) {
            let [a, b, c] = added;
            for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(b).zip(c)) {
                *value += x * a + y * b + z * c;
            }
        }
    }
    evidence
}

/// Evaluates a group's map; it adds nothing where nothing is known.
#[inline]
fn evaluate_map<'a>(
    group: &Group<'_>,
    features: &[f32],
    scratch: &'a mut [f32],
) -> (Evidence, &'a [f32]) {
    let (input, scratch) = split(scratch, padded(group.input_len()));
    let (added, scratch) = split(scratch, padded(12 * group.proxies.len()));
    for (x, (feature, weight)) in input.iter_mut().zip(group.inputs()) {
        *x = weight * features.get(feature).copied().unwrap_or_default();
    }
    let input = input.get(..group.input_len()).unwrap_or_default();
    group.map.evaluate(input, scratch, added)
}
