//! How far a pose may be from one of the skeleton's.

use super::view::Envelope;
use crate::linear::{Matrix3x4, inverse};

/// How far the products of a matrix's rows may be from those of a rotation: a scale of 1.001.
pub const RIGID_TOLERANCE: f32 = 2.0e-3;
/// How much farther than in training a joint may come from where its parent carries it.
pub const GAP_MARGIN: f32 = 2.0;
/// What any joint may be off, as a share of the diagonal: more than rounding, and less than one sees.
pub const GAP_TOLERANCE: f32 = 1.0e-3;

/// Returns how far a joint may be off its parent in any pose, but for what rounding leaves.
#[inline]
pub(super) fn allowance(diagonal: f32, gap: f32) -> f32 {
    GAP_TOLERANCE * diagonal + GAP_MARGIN * gap
}

/// Returns [`allowance`] of a joint.
pub(super) fn allowance_of(envelope: &Envelope<'_>, joint: usize) -> f32 {
    allowance(envelope.certificate().diagonal, envelope.pose_gap(joint).unwrap_or_default())
}

/// Returns the rest origin of a joint in model space, by its inverse bind matrix.
#[inline]
pub(super) fn origin(bind: &Matrix3x4) -> [f32; 3] {
    inverse(bind).map(|[.., shift]| shift)
}
