//! Stage joints: the joints themselves, and the base of each helper (METHOD §1.9).

use super::view::Envelope;
use crate::linear::{Matrix3x4, split};

/// Evaluates the stage: [`crate::stages::joints`] of arguments that have been checked.
pub(crate) fn evaluate(envelope: &Envelope<'_>, pose: &[Matrix3x4], out_palette: &mut [Matrix3x4]) {
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
