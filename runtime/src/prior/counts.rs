//! The numbers of a prior: how large it is, how good it is.

use super::packed::packed_len;
use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, Rule};

/// Counts of a prior, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PriorCounts {
    /// The part that is its skin.
    pub skin: u32,
    /// Shapes of the skin, S.
    pub shape_len: u32,
    /// Pairs of shapes that mirror each other.
    pub symmetry_len: u32,
    /// Pairs of shapes of which one alone is at work.
    pub cancel_len: u32,
}

impl PriorCounts {
    /// Bytes of section `prior_counts`.
    pub const BYTES: usize = 16;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 4] {
        let Self { skin, shape_len, symmetry_len, cancel_len } = *self;
        [skin, shape_len, symmetry_len, cancel_len]
    }

    /// Makes them of their words.
    pub const fn from_words(words: [u32; 4]) -> Self {
        let [skin, shape_len, symmetry_len, cancel_len] = words;
        Self { skin, shape_len, symmetry_len, cancel_len }
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no prior has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let Self { shape_len: s, symmetry_len: y, cancel_len: c, .. } = *self;
        // More shapes than the format holds are refused before this counts.
        let shapes = if s > u16::MAX as u32 { 0 } else { s };
        Asked::new(ALWAYS, [1, s, packed_len(shapes as usize) as u32, y, c])
    }
}

/// How stiff pins are by default, and what a prior was measured to reach. Lengths are in the file's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PriorFit {
    /// β: the square of the length by which a pin may miss.
    pub beta: f32,
    /// Frames that it was learned from; 0 of one that was not.
    pub frames: f32,
    /// RMS over vertices of the distance to held-out frames, with the pins that its maker states; 0 if not measured.
    pub error: f32,
    /// The same of the prior without covariance; 0 if not measured.
    pub slider_error: f32,
}

impl PriorFit {
    /// Bytes of section `prior_fit`.
    pub const BYTES: usize = 16;

    /// Lists its figures in the order of the file.
    pub const fn figures(&self) -> [f32; 4] {
        let Self { beta, frames, error, slider_error } = *self;
        [beta, frames, error, slider_error]
    }

    /// Makes it of its figures.
    pub const fn from_figures([beta, frames, error, slider_error]: [f32; 4]) -> Self {
        Self { beta, frames, error, slider_error }
    }
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const SKIN: usize = 0;
    pub(crate) const SHAPES: usize = 1;
}

/// The sections of a prior, in the order in which the trainer writes them.
pub const PRIOR_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && PriorCounts::BYTES <= 4 * COUNTS);

/// What a prior asks of its sections. Sizes: 1, S, S (S + 1) / 2, pairs that mirror, pairs that cancel.
pub(crate) const RULES: [Rule; 8] = [
    Rule::new(SectionKind::PriorCounts, PriorCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [0, 0]).or_more(0),
    Rule::floats(SectionKind::PriorMean, 4, [1, 0]),
    Rule::floats(SectionKind::PriorFactor, 4, [2, 0]),
    Rule::floats(SectionKind::WeightBounds, 8, [1, 0]),
    Rule::new(SectionKind::Symmetry, 8, [3, 0]).floats_after(1),
    Rule::new(SectionKind::CancelPairs, 4, [4, 0]),
    Rule::floats(SectionKind::PriorFit, PriorFit::BYTES as u8, [0, 0]).unsigned(),
];
