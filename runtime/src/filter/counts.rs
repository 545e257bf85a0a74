//! The numbers of a filter: how large it is, how good it is.

use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};

/// Counts of a filter, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilterCounts {
    /// Fine samples of each coarse one, F.
    pub factor: u32,
    /// Coarse samples of a window, N: odd.
    pub tap_len: u32,
}

impl FilterCounts {
    /// Bytes of section `filter_counts`.
    pub const BYTES: usize = 8;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 2] {
        let Self { factor, tap_len } = *self;
        [factor, tap_len]
    }

    /// Makes them of their words.
    pub const fn from_words([factor, tap_len]: [u32; 2]) -> Self {
        Self { factor, tap_len }
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no filter has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let Self { factor, tap_len } = *self;
        Asked::new(ALWAYS, [1, tap_len, factor.saturating_mul(tap_len)])
    }
}

/// How far a filter was measured to be from what it was trained on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilterFit {
    /// From one coarse sample to the next, in the unit of what the signal runs along; 0 if it has none.
    pub step: f32,
    /// RMS over samples that were left out, in the signal's unit; 0 if it was not measured.
    pub left_out_rms: f32,
    /// The same of linear interpolation.
    pub linear_rms: f32,
}

impl FilterFit {
    /// Bytes of section `filter_fit`.
    pub const BYTES: usize = 12;

    /// Lists its figures in the order of the file.
    pub const fn figures(&self) -> [f32; 3] {
        let Self { step, left_out_rms, linear_rms } = *self;
        [step, left_out_rms, linear_rms]
    }

    /// Makes it of its figures.
    pub const fn from_figures([step, left_out_rms, linear_rms]: [f32; 3]) -> Self {
        Self { step, left_out_rms, linear_rms }
    }
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const FACTOR: usize = 0;
    pub(crate) const TAPS: usize = 1;
}

/// The sections of a filter, in the order in which the trainer writes them.
pub const FILTER_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && FilterCounts::BYTES <= 4 * COUNTS);

/// What a filter asks of its sections. Sizes: 1, N, F N.
pub(crate) const RULES: [Rule; 5] = [
    Rule::new(SectionKind::FilterCounts, FilterCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [0, 0]).or_more(0),
    Rule::floats(SectionKind::FilterTaps, 4, [1, 2]),
    Rule::floats(SectionKind::FilterVariances, 4, [2, 0]).with(OPTIONAL).unsigned(),
    Rule::floats(SectionKind::FilterFit, FilterFit::BYTES as u8, [0, 0]).unsigned(),
];
