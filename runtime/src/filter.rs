//! The part filter: increases the sampling rate of a signal or an image. The weights depend only on
//! the position of a fine sample between the coarse samples (METHOD §4).
//!
//! [`Filter::apply`] slides a window along the samples. The file holds the weights for every
//! distance from the signal's ends and for every phase.

use crate::error::{Argument, CallError};
use crate::format::content;
use crate::format::flat::flat;
use crate::format::part::{self, Asked, COUNTS, Part, SECTIONS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};
use crate::format::{MAGNITUDE_MAX, SectionKind};
use crate::linear::{Le, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const TAPS: usize = Rule::place(&RULES, SectionKind::FilterTaps);
const VARIANCES: usize = Rule::place(&RULES, SectionKind::FilterVariances);
const FIT: usize = Rule::place(&RULES, SectionKind::FilterFit);

/// Weights that make F fine samples from each coarse sample; borrowed from a loaded model.
///
/// Accessors by number return `None` if the number is out of range.
#[derive(Clone, Copy)]
pub struct Filter<'a>(pub(crate) Part<'a>);

part::view! { Filter, Filter, |words| -> FilterCounts { FilterCounts::from_words(first_counts(words)) } }

impl<'a> Filter<'a> {
    /// Returns F, the number of fine samples per coarse sample.
    pub const fn factor(&self) -> usize {
        self.counts().factor as usize
    }

    /// Returns N, the number of coarse samples in a window. A signal must have at least N samples.
    pub const fn tap_len(&self) -> usize {
        self.counts().tap_len as usize
    }

    /// Returns the weight of a coarse sample of a window for a fine sample.
    ///
    /// - `place`: place in the window of the coarse sample with the fine sample's phase.
    /// - `phase`: number of the fine sample among the F of its coarse sample.
    /// - `tap`: number of the coarse sample in the window.
    pub fn tap(&self, place: usize, phase: usize, tap: usize) -> Option<f32> {
        let start = self.row(place, phase)? * self.tap_len();
        let taps = self.taps().get(start..)?.get(..self.tap_len())?;
        taps.get(tap).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the variance of a fine sample; `None` also if the file has no variances.
    ///
    /// - `place`, `phase`: as for [`Filter::tap`].
    pub fn variance(&self, place: usize, phase: usize) -> Option<f32> {
        let row = self.row(place, phase)?;
        self.0.bytes(VARIANCES).as_chunks().0.get(row).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the window of a coarse sample in a signal of `sample_len` samples: the window's
    /// start, and the sample's place in the window. Inside the signal the place is the middle. Near
    /// an end the window stops moving and the place changes.
    pub fn window(&self, sample: usize, sample_len: usize) -> (usize, usize) {
        let last = sample_len.saturating_sub(self.tap_len());
        let start = sample.saturating_sub(self.tap_len() / 2).min(last);
        (start, sample.saturating_sub(start))
    }

    /// Returns the measured error of the filter on its training data.
    pub fn fit(&self) -> FilterFit {
        FilterFit::from_figures(self.0.array(FIT).first().map(floats).unwrap_or_default())
    }

    /// All taps, sorted by place and then by phase.
    fn taps(&self) -> &'a [Le] {
        self.0.bytes(TAPS).as_chunks().0
    }

    fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    fn row(&self, place: usize, phase: usize) -> Option<usize> {
        let is_inside = place < self.tap_len() && phase < self.factor();
        is_inside.then(|| place * self.factor() + phase)
    }
}

/// Layout of samples: `signal_len` signals in sequence, each of `sample_len` rows of `lane_len`
/// numbers.
///
/// A single signal has one lane. Take an image of H rows of W pixels of C channels. Along its
/// columns the image is one signal of H rows with W C lanes. Along its rows the image is H signals
/// of W rows with C lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// Number of signals.
    pub signal_len: usize,
    /// Samples of each signal.
    pub sample_len: usize,
    /// Numbers per sample; each is filtered independently.
    pub lane_len: usize,
}

/// Lanes that are summed together.
const WIDE: usize = 8;

impl Samples {
    /// Makes the layout of a single signal.
    pub const fn of_signal(sample_len: usize) -> Self {
        Self { signal_len: 1, sample_len, lane_len: 1 }
    }

    /// Returns the number of numbers; saturates at `usize::MAX`.
    const fn len(&self) -> usize {
        self.signal_len.saturating_mul(self.sample_len).saturating_mul(self.lane_len)
    }
}

impl Filter<'_> {
    /// Computes F fine samples for each sample.
    ///
    /// Fine sample `F i + p` is a weighted sum over the N coarse samples in the window of coarse
    /// sample i. The weights are the taps for the sample's place in the window and for phase p; the
    /// sum runs from first to last (METHOD §4). An image needs two calls, one along its columns and
    /// one along its rows.
    ///
    /// - `shape`: layout of `samples`. The output has the same layout, with F times the samples per
    ///   signal.
    /// - `samples`: the numbers.
    /// - `out`: receives F times the numbers.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::TooShort`]: a signal has fewer than N samples.
    /// - [`crate::CallErrorKind::Length`]: `samples` or `out` has another length.
    /// - [`crate::CallErrorKind::NonFinite`]: a number is not finite, or larger than [`MAGNITUDE_MAX`].
    pub fn apply(&self, shape: Samples, samples: &[f32], out: &mut [f32]) -> Result<(), CallError> {
        Argument::Samples.check_least(self.tap_len(), shape.sample_len)?;
        Argument::Samples.check_len(shape.len(), samples.len())?;
        Argument::Outputs.check_len(shape.len().saturating_mul(self.factor()), out.len())?;
        let is_sound = |x: &f32| x.abs() <= MAGNITUDE_MAX;
        Argument::Samples.check_finite(samples.iter().position(|x| !is_sound(x)))?;
        let Samples { sample_len, lane_len, .. } = shape;
        // An empty shape writes nothing; a chunk length of zero would panic.
        let coarse = samples.chunks_exact((sample_len * lane_len).max(1));
        let fine = out.chunks_exact_mut((sample_len * self.factor() * lane_len).max(1));
        for (coarse, fine) in coarse.zip(fine) {
            self.apply_to_signal(shape, coarse, fine);
        }
        Ok(())
    }

    /// Filters one signal. `None` never occurs for a loaded filter.
    fn apply_to_signal(&self, shape: Samples, coarse: &[f32], fine: &mut [f32]) -> Option<()> {
        let Samples { sample_len, lane_len, .. } = shape;
        let (tap_len, factor, taps) = (self.tap_len(), self.factor(), self.taps());
        let fine = fine.chunks_exact_mut((factor * lane_len).max(1));
        for (sample, fine) in (0..sample_len).zip(fine) {
            let (start, place) = self.window(sample, sample_len);
            let window = coarse.get(start * lane_len..)?.get(..tap_len * lane_len)?;
            let phases = taps.get(place * factor * tap_len..)?.chunks_exact(tap_len.max(1));
            for (taps, out) in phases.zip(fine.chunks_exact_mut(lane_len.max(1))) {
                sum_lanes(taps, window, out);
            }
        }
        Some(())
    }
}

/// Sums the weighted samples of a window, for all lanes.
fn sum_lanes(taps: &[Le], window: &[f32], out: &mut [f32]) {
    let lane_len = out.len();
    let (wide, rest) = out.as_chunks_mut::<WIDE>();
    for (chunk, out) in wide.iter_mut().enumerate() {
        *out = sums(taps, window, lane_len, WIDE * chunk);
    }
    let first = lane_len - rest.len();
    for (lane, out) in rest.iter_mut().enumerate() {
        [*out] = sums(taps, window, lane_len, first + lane);
    }
}

/// Sums L lanes, starting at lane `first`, in the order of the taps.
#[inline(always)]
fn sums<const L: usize>(taps: &[Le], window: &[f32], lane_len: usize, first: usize) -> [f32; L] {
    let mut sums = [0.0; L];
    for (tap, row) in taps.iter().zip(window.chunks_exact(lane_len.max(1))) {
        let tap = f32::from_le_bytes(*tap);
        let lanes = row.get(first..).and_then(<[f32]>::first_chunk::<L>);
        for (sum, x) in sums.iter_mut().zip(lanes.unwrap_or(&[0.0; L])) {
            *sum += tap * x;
        }
    }
    sums
}

/// Counts of a filter. The length of every section follows from the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) struct FilterCounts {
    /// Fine samples per coarse sample, F.
    pub factor: u32,
    /// Coarse samples of a window, N; odd.
    pub tap_len: u32,
}

flat! { FilterCounts of "filter_counts", words, from_words: [u32; 2] { factor, tap_len } }

impl FilterCounts {
    /// Computes a section's length in bytes, or the least length of the names; `None` if filters
    /// lack the section.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the requirements for the sections, in the terms of [`RULES`].
    const fn asked(&self) -> Asked {
        let Self { factor, tap_len } = *self;
        Asked::new(ALWAYS, [1, tap_len, factor.saturating_mul(tap_len)])
    }
}

/// Measured error of a filter on its training data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct FilterFit {
    /// Distance between coarse samples, in units of the signal's axis; 0 without a unit.
    pub step: f32,
    /// RMS error over left-out samples, in the signal's unit; 0 if not measured.
    pub left_out_rms: f32,
    /// RMS error of linear interpolation over the samples of `left_out_rms`.
    pub linear_rms: f32,
}

flat! { FilterFit of "filter_fit", figures, from_figures: [f32; 3] {
    step, left_out_rms, linear_rms
} }

/// Indices of the counts in their section.
mod place {
    pub(super) const FACTOR: usize = 0;
    pub(super) const TAPS: usize = 1;
}

/// The sections of a filter, in the trainer's order.
#[cfg_attr(feature = "internals", visibility::make(pub))]
pub(crate) const FILTER_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && FilterCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of a filter. Sizes: 1, N, F N.
pub(crate) const RULES: [Rule; 5] = [
    Rule::new(SectionKind::FilterCounts, FilterCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [0, 0]).or_more(0),
    Rule::floats(SectionKind::FilterTaps, 4, [1, 2]),
    Rule::floats(SectionKind::FilterVariances, 4, [2, 0]).with(OPTIONAL).unsigned(),
    Rule::floats(SectionKind::FilterFit, FilterFit::BYTES as u8, [0, 0]).unsigned(),
];

/// Checks a filter's counts, and returns the requirements for its sections.
pub(crate) fn check_counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    let section = SectionKind::FilterCounts;
    let most = u32::from(u16::MAX);
    content::check_counts(
        loading,
        section,
        words,
        &[(place::FACTOR, 1, most), (place::TAPS, 1, most)],
    )?;
    let counts = FilterCounts::from_words(first_counts(words));
    if counts.tap_len.is_multiple_of(2) {
        return loading.invalid(section, place::TAPS).map(|()| counts.asked());
    }
    Ok(counts.asked())
}

/// Checks the content of a filter. The lengths of all sections have been checked before.
pub(crate) fn check_content(filter: &Filter<'_>, loading: &Loading<'_>) -> Checked {
    content::check_names(loading, filter.names())?;
    content::check_floats(loading, &filter.0, &RULES)
}
