//! A filter in a loaded file: what loading found of it, and what it holds.

use super::counts::{FilterCounts, FilterFit, RULES};
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::{Le, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const TAPS: usize = Rule::place(&RULES, SectionKind::FilterTaps);
const VARIANCES: usize = Rule::place(&RULES, SectionKind::FilterVariances);
const FIT: usize = Rule::place(&RULES, SectionKind::FilterFit);

/// Weights that make F fine samples of each coarse one; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Filter<'a>(pub(crate) Part<'a>);

part::view! { Filter, FilterLayout, |words| -> FilterCounts { FilterCounts::from_words(first_counts(words)) } }

impl<'a> Filter<'a> {
    /// Returns F, the number of fine samples of each coarse one.
    pub const fn factor(&self) -> usize {
        self.counts().factor as usize
    }

    /// Returns N, the number of coarse samples that each fine one is made of. No signal may be shorter.
    pub const fn tap_len(&self) -> usize {
        self.counts().tap_len as usize
    }

    /// Returns by how much a coarse sample of a window counts for a fine one.
    ///
    /// - `place`: that of the sample which the fine one is a phase of, in the window.
    /// - `phase`: number of the fine sample among that one's F.
    /// - `tap`: number of the coarse sample in the window.
    pub fn tap(&self, place: usize, phase: usize, tap: usize) -> Option<f32> {
        let start = self.row(place, phase)? * self.tap_len();
        let taps = self.taps().get(start..)?.get(..self.tap_len())?;
        taps.get(tap).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the variance of a fine sample, likewise; `None` also if the file has none.
    pub fn variance(&self, place: usize, phase: usize) -> Option<f32> {
        let row = self.row(place, phase)?;
        self.0.bytes(VARIANCES).as_chunks().0.get(row).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the window of a coarse sample among as many as there are: where it starts, and the sample's place in
    /// it. Inside, that is the middle; towards an end the window stays and the sample moves.
    pub fn window(&self, sample: usize, sample_len: usize) -> (usize, usize) {
        let last = sample_len.saturating_sub(self.tap_len());
        let start = sample.saturating_sub(self.tap_len() / 2).min(last);
        (start, sample.saturating_sub(start))
    }

    /// Returns how far it was measured to be from what it was trained on.
    pub fn fit(&self) -> FilterFit {
        FilterFit::from_figures(self.0.array(FIT).first().map(floats).unwrap_or_default())
    }

    /// All taps: place by place, phase by phase.
    pub(super) fn taps(&self) -> &'a [Le] {
        self.0.bytes(TAPS).as_chunks().0
    }

    pub(super) fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    fn row(&self, place: usize, phase: usize) -> Option<usize> {
        let is_inside = place < self.tap_len() && phase < self.factor();
        is_inside.then(|| place * self.factor() + phase)
    }
}
