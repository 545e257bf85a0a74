//! A filter in a loaded file: what loading found of it, and what it holds.

use super::counts::{FilterCounts, FilterFit, RULES};
use crate::format::part::{Part, PartLayout, first_counts};
use crate::format::rule::Rule;
use crate::format::{FileId, SectionKind};
use crate::linear::{Le, floats};
use crate::names::Names;
use core::fmt;

/// What loading found of a filter: its counts, and where its arrays lie. It borrows nothing, so that it can be kept
/// beside the model, and views be made of it each time.
#[derive(Clone, Copy, Debug)]
pub struct FilterLayout(pub(crate) PartLayout);

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const TAPS: usize = Rule::place(&RULES, SectionKind::FilterTaps);
const VARIANCES: usize = Rule::place(&RULES, SectionKind::FilterVariances);
const FIT: usize = Rule::place(&RULES, SectionKind::FilterFit);

impl FilterLayout {
    /// Returns the filter; `None` if the bytes are not those of the file in which it was found, by their length and
    /// the checksum that they state.
    ///
    /// Nothing is read again. Of bytes that have changed otherwise the filter gives wrong numbers, but never panics.
    pub fn open<'a>(&self, file: &'a [u8]) -> Option<Filter<'a>> {
        self.0.open(file).map(Filter)
    }

    /// Returns the counts.
    pub const fn counts(&self) -> FilterCounts {
        FilterCounts::from_words(first_counts(&self.0.counts))
    }
}

/// Weights that make F fine samples of each coarse one; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Filter<'a>(pub(crate) Part<'a>);

impl<'a> Filter<'a> {
    /// Returns what loading found, to open it again.
    pub const fn layout(&self) -> FilterLayout {
        FilterLayout(self.0.layout)
    }

    /// Tells in which file it is.
    pub const fn file(&self) -> FileId {
        self.0.id()
    }

    /// Returns its place in [`crate::Model::parts`], by which [`crate::Model::sections`] are told apart.
    pub const fn part(&self) -> usize {
        self.0.index()
    }

    /// Returns the part's name.
    pub fn name(&self) -> &'a str {
        self.names().get(0).unwrap_or_default()
    }

    /// Returns its counts.
    pub const fn counts(&self) -> FilterCounts {
        self.layout().counts()
    }

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

impl fmt::Debug for Filter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, counts) = (self.name(), self.counts());
        f.debug_struct("Filter").field("name", &name).field("counts", &counts).finish()
    }
}
