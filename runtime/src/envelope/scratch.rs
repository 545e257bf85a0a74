//! Layout of the scratch of an evaluation, on a CPU and on a GPU.

use super::counts::{EnvelopeCounts, STRAIN_LEN};
use super::view::Envelope;
use crate::linear::{Columns, split};

/// Offsets of the arrays in the scratch of one pose, in floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScratchLayout {
    /// Stack q: 4 J columns of 3.
    pub relative: usize,
    /// J rotation vectors of 3.
    pub rotations: usize,
    /// Stack d: 3 P columns of 3.
    pub gradients: usize,
    /// Features: J matrices of 12, then J strains of 6 if joints stretch, then C curves.
    pub features: usize,
    /// J rotations of 9, if joints stretch.
    pub turns: usize,
    /// J strains of 6, if joints stretch.
    pub strains: usize,
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
/// The base of a rotational envelope needs 12 J + 3 J + 9 P. The correction of a kernel envelope needs its features
/// and [`EnvelopeCounts::correction_len`]. If joints stretch, a rotational envelope needs 15 J more, a kernel envelope
/// 9 J.
pub const fn scratch_len(counts: &EnvelopeCounts) -> usize {
    ScratchLayout::in_turn(counts).len
}

impl ScratchLayout {
    /// Lays out stages and groups that are evaluated in turn, as on a CPU. The arrays share memory.
    pub const fn in_turn(counts: &EnvelopeCounts) -> Self {
        if counts.predictor.reconstructs() {
            return Self::of_base(counts);
        }
        let joints = counts.joint_len as usize;
        let turns = counts.feature_len();
        let groups = turns + 9 * counts.stretching();
        let correction = counts.correction_len as usize;
        let len = if correction > 0 { groups.saturating_add(correction) } else { 0 };
        Self { turns, strains: 12 * joints, groups, len, ..Self::NOTHING }
    }

    /// Lays out the stages of a rotational envelope. A program without kernel maps links only this layout.
    pub(crate) const fn of_base(counts: &EnvelopeCounts) -> Self {
        let (joints, stretching) = (counts.joint_len as usize, counts.stretching());
        let (rotations, gradients) = (12 * joints, 15 * joints);
        let strains = gradients + 9 * counts.proxy_len as usize;
        let turns = strains + STRAIN_LEN * stretching;
        let len = turns + 9 * stretching;
        Self { rotations, gradients, strains, turns, groups: strains, len, ..Self::NOTHING }
    }

    const NOTHING: Self = Self {
        relative: 0,
        rotations: 0,
        gradients: 0,
        features: 0,
        turns: 0,
        strains: 0,
        confidences: 0,
        groups: 0,
        group_stride: 0,
        len: 0,
    };

    /// Lays out groups that are evaluated at once, as on a GPU. Every stage keeps its results.
    ///
    /// The scratch of a group is x (d), g (n) and [z h] (r + m), each in whole blocks of 8.
    pub fn at_once(envelope: &Envelope<'_>) -> Self {
        let counts = envelope.counts();
        let padded = |len: usize| len.next_multiple_of(8);
        let sizes = envelope.groups().map(|group| {
            let (d, n, r) = (group.input_len(), group.centre_len(), group.rank());
            padded(d) + padded(n) + padded(r + group.certainty_len())
        });
        let group_stride = sizes.max().unwrap_or(0);
        let group_len = envelope.group_len();
        let in_turn = Self::in_turn(&counts);
        let (features, confidences, groups);
        let Self { rotations, gradients, turns, strains, .. } = in_turn;
        if counts.predictor.reconstructs() {
            (features, confidences, groups) = (in_turn.len, in_turn.len, in_turn.len);
        } else {
            let correction = usize::from(group_len > 0);
            features = 0;
            confidences = correction * in_turn.groups;
            groups = confidences + 2 * group_len;
        }
        let len = groups.saturating_add(group_len.saturating_mul(group_stride));
        Self {
            relative: 0,
            rotations,
            gradients,
            features,
            turns,
            strains,
            confidences,
            groups,
            group_stride,
            len,
        }
    }

    /// Splits off the stacks of the base: 4 J columns, J rotation vectors, 3 P columns, J strains, J rotations.
    pub(crate) fn base<'a>(&self, scratch: &'a mut [f32]) -> Base<'a> {
        let (relative, rest) = split(scratch, self.rotations);
        let (rotations, rest) = split(rest, self.gradients - self.rotations);
        let (gradients, rest) = split(rest, self.strains - self.gradients);
        let (strains, rest) = split(rest, self.turns - self.strains);
        let (turns, _) = split(rest, self.len - self.turns);
        Base {
            relative: relative.as_chunks_mut().0,
            rotations: rotations.as_chunks_mut().0,
            gradients: gradients.as_chunks_mut().0,
            strains: strains.as_chunks_mut().0,
            turns: turns.as_chunks_mut::<3>().0.as_chunks_mut().0,
        }
    }

    /// Splits off the features, J rotations, and the scratch of a group.
    pub(crate) fn correction<'a>(
        &self,
        scratch: &'a mut [f32],
    ) -> (&'a mut [f32], &'a mut [Columns], &'a mut [f32]) {
        let (features, rest) = split(scratch, self.turns);
        let (turns, group) = split(rest, self.groups - self.turns);
        (features, turns.as_chunks_mut::<3>().0.as_chunks_mut().0, group)
    }
}

/// Stacks of columns for the reconstruction.
pub(crate) struct Base<'a> {
    pub(crate) relative: &'a mut [[f32; 3]],
    pub(crate) rotations: &'a mut [[f32; 3]],
    pub(crate) gradients: &'a mut [[f32; 3]],
    pub(crate) strains: &'a mut [[f32; STRAIN_LEN]],
    pub(crate) turns: &'a mut [Columns],
}
