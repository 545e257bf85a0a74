//! The kernel maps' correction.

mod agreement;
mod exact;
mod ranges;
mod reference;

use crate::common::{IDENTITY, bits};
use models::GroupContent;
use sinew_runtime::{Envelope, Matrix3x4, stages};

/// The palette before the correction: the joints, and the dominant joint's transform for each
/// helper; the identity without joints.
fn base(groups: &[GroupContent], pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    let dominant = |joint: usize| *pose.get(joint).unwrap_or(&IDENTITY);
    let of_group = |g: &GroupContent| vec![dominant(g.joint); g.proxies];
    pose.iter().copied().chain(groups.iter().flat_map(of_group)).collect()
}

/// Runs stages polar, if joints stretch, and features.
fn features(envelope: &Envelope<'_>, pose: &[Matrix3x4], curves: &[f32]) -> Vec<f32> {
    let mut phi = vec![f32::NAN; envelope.counts().feature_len()];
    let len = if envelope.stretches() { pose.len() } else { 0 };
    let mut turns = vec![[[f32::NAN; 3]; 3]; len];
    if envelope.stretches() {
        let strains = phi[12 * len..18 * len].as_chunks_mut().0;
        stages::polar(envelope, pose, &mut turns, strains).unwrap();
    }
    stages::features(envelope, pose, curves, &turns, &mut phi).unwrap();
    phi
}

/// Runs the correction after its features, in scratch of exactly the stated length.
fn corrected(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
    base: &[Matrix3x4],
) -> (Vec<Matrix3x4>, f32) {
    let phi = features(envelope, pose, curves);
    let mut out = base.to_vec();
    let mut scratch = vec![f32::NAN; envelope.correction_len()];
    let confidence = stages::correction(envelope, pose, &phi, &mut scratch, &mut out).unwrap();
    (out, confidence)
}

fn flat(transforms: &[Matrix3x4]) -> &[f32] {
    transforms.as_flattened().as_flattened()
}

fn flat_bits(transforms: &[Matrix3x4]) -> Vec<u32> {
    bits(flat(transforms))
}
