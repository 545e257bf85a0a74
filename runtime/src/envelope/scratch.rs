//! Layout of the scratch of an evaluation, on a CPU and on a GPU.

use super::view::Envelope;
use crate::linear::{Matrix3x4, split};

/// Offsets of the arrays in the scratch of one pose, in floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScratchLayout {
    /// Stack q: 4 J columns of 3.
    pub relative: usize,
    /// J rotation vectors of 3.
    pub rotations: usize,
    /// Stack d: 3 P columns of 3.
    pub gradients: usize,
    /// Features: J matrices of 12.
    pub features: usize,
    /// Explained and unexplained error of each of the G groups; used only if groups are evaluated at once.
    pub confidences: usize,
    /// Scratch of the first group.
    pub groups: usize,
    /// Distance from a group's scratch to the next group's scratch; 0 if groups are evaluated in turn.
    pub group_stride: usize,
    /// Length of the whole scratch.
    pub len: usize,
}

/// Returns the floats of scratch that [`Envelope::palette`] needs.
///
/// The base needs 12 J + 3 J + 9 P. A correction needs 12 J + [`super::EnvelopeCounts::correction_len`]. The result is
/// the greater of the two.
pub const fn scratch_len(joint_len: usize, proxy_len: usize, correction_len: usize) -> usize {
    ScratchLayout::in_turn(joint_len, proxy_len, correction_len).len
}

impl ScratchLayout {
    /// Lays out stages and groups that are evaluated in turn, as on a CPU. The arrays share memory.
    pub const fn in_turn(joint_len: usize, proxy_len: usize, correction_len: usize) -> Self {
        let (rotations, gradients) = (12 * joint_len, 15 * joint_len);
        let base = gradients + 9 * proxy_len;
        let all = correction_len.saturating_add(12 * joint_len);
        let correction = if correction_len > 0 { all } else { 0 };
        Self {
            relative: 0,
            rotations,
            gradients,
            features: 0,
            confidences: 0,
            groups: 12 * joint_len,
            group_stride: 0,
            len: if base > correction { base } else { correction },
        }
    }

    /// Lays out groups that are evaluated at once, as on a GPU. Every stage keeps its results.
    ///
    /// The scratch of a group is x (d), g (n) and [z h] (r + m), each in whole blocks of 8.
    pub fn at_once(envelope: &Envelope<'_>) -> Self {
        let (joint_len, group_len) = (envelope.joint_len(), envelope.group_len());
        let base = usize::from(envelope.predictor().reconstructs());
        let correction = usize::from(group_len > 0);
        let padded = |len: usize| len.next_multiple_of(8);
        let sizes = envelope.groups().map(|group| {
            let (d, n, r) = (group.input_len(), group.centre_len(), group.rank());
            padded(d) + padded(n) + padded(r + group.certainty_len())
        });
        let group_stride = sizes.max().unwrap_or(0);
        let rotations = base * 12 * joint_len;
        let gradients = rotations + base * 3 * joint_len;
        let features = gradients + base * 9 * envelope.proxy_len();
        let confidences = features + correction * 12 * joint_len;
        let groups = confidences + 2 * group_len;
        let len = groups.saturating_add(group_len.saturating_mul(group_stride));
        Self { relative: 0, rotations, gradients, features, confidences, groups, group_stride, len }
    }

    /// Splits off the stacks of the base: 4 J columns, J rotation vectors, 3 P columns.
    pub(crate) fn base<'a>(&self, scratch: &'a mut [f32], proxy_len: usize) -> Base<'a> {
        let (columns, _) = scratch.as_chunks_mut::<3>();
        let (relative, columns) = split(columns, self.rotations / 3);
        let (rotations, columns) = split(columns, (self.gradients - self.rotations) / 3);
        let (gradients, _) = split(columns, 3 * proxy_len);
        Base { relative, rotations, gradients }
    }

    /// Splits off J features, and the scratch of a group.
    pub(crate) fn correction<'a>(
        &self,
        scratch: &'a mut [f32],
    ) -> (&'a mut [Matrix3x4], &'a mut [f32]) {
        let (features, group) = split(scratch, self.groups);
        (features.as_chunks_mut::<4>().0.as_chunks_mut::<3>().0, group)
    }
}

/// Stacks of columns for the reconstruction.
pub(crate) struct Base<'a> {
    pub(crate) relative: &'a mut [[f32; 3]],
    pub(crate) rotations: &'a mut [[f32; 3]],
    pub(crate) gradients: &'a mut [[f32; 3]],
}
