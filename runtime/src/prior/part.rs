//! A prior in a loaded file: its counts, sections, accessors and checks.

use super::packed::{packed_len, rows};
use crate::format::content;
use crate::format::flat::flat;
use crate::format::part::{self, Asked, COUNTS, Part, SECTIONS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::rule::{ALWAYS, Rule};
use crate::format::{FileErrorKind as Kind, SectionKind};
use crate::linear::{Le, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MEAN: usize = Rule::place(&RULES, SectionKind::PriorMean);
const FACTOR: usize = Rule::place(&RULES, SectionKind::PriorFactor);
const BOUNDS: usize = Rule::place(&RULES, SectionKind::WeightBounds);
const SYMMETRY: usize = Rule::place(&RULES, SectionKind::Symmetry);
const CANCEL: usize = Rule::place(&RULES, SectionKind::CancelPairs);
const FIT: usize = Rule::place(&RULES, SectionKind::PriorFit);

/// Least share of a weight's precision that its diagonal entry in the factor may keep. Rounding in
/// f64 stays far below this share, so every accepted prior has a factor with any pins. A floor of
/// 0.1 on variances leaves 2e-3 with 53 shapes.
const SHARE_MIN: f64 = 1.0e-10;

/// Mean and precision of the weights of a skin's S shapes; borrowed from a loaded model.
///
/// Accessors by number return `None` if the number is out of range.
#[derive(Clone, Copy)]
pub struct Prior<'a>(pub(crate) Part<'a>);

part::view! { Prior, Prior, |words| -> PriorCounts { PriorCounts::from_words(first_counts(words)) } }

impl<'a> Prior<'a> {
    /// Returns S, the number of shapes.
    pub const fn shape_len(&self) -> usize {
        self.counts().shape_len as usize
    }

    /// Returns the mean weight of a shape.
    pub fn mean(&self, shape: usize) -> Option<f32> {
        self.means().get(shape).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns an entry of U. The precision is Uᵀ U; entries below the diagonal are 0.
    pub fn factor_entry(&self, row: usize, column: usize) -> Option<f32> {
        let n = self.shape_len();
        if row >= n || column >= n {
            return None;
        }
        let Some(after) = column.checked_sub(row) else { return Some(0.0) };
        let start = packed_len(n) - packed_len(n - row);
        self.factor().get(start + after).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the least and the greatest weight of a shape.
    pub fn weight_bounds(&self, shape: usize) -> Option<[f32; 2]> {
        self.0.entry(BOUNDS, self.shape_len(), shape).map(floats)
    }

    /// Lists the pairs of mirrored shapes, each with its stiffness: the reciprocal of their mean
    /// squared difference.
    pub fn symmetry(&self) -> impl Iterator<Item = ([usize; 2], f32)> + use<'a> {
        self.symmetry_rows()
            .iter()
            .map(|[pair, stiffness]| (shapes(pair), f32::from_le_bytes(*stiffness)))
    }

    /// Lists the pairs of mutually exclusive shapes.
    pub fn cancel_pairs(&self) -> impl Iterator<Item = [usize; 2]> + use<'a> {
        self.cancel_rows().iter().map(shapes)
    }

    /// Returns the default stiffness of pins, and the measured accuracy of the prior.
    pub fn fit(&self) -> PriorFit {
        let figures = self.0.array(FIT).first().map(floats);
        PriorFit::from_figures(figures.unwrap_or_default())
    }

    pub(super) fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    pub(super) fn means(&self) -> &'a [Le] {
        self.0.bytes(MEAN).as_chunks().0
    }

    /// Rows of U, packed.
    pub(super) fn factor(&self) -> &'a [Le] {
        self.0.bytes(FACTOR).as_chunks().0
    }

    pub(super) fn bounds(&self) -> &'a [[Le; 2]] {
        self.0.array(BOUNDS)
    }

    pub(super) fn symmetry_rows(&self) -> &'a [[Le; 2]] {
        self.0.array(SYMMETRY)
    }

    pub(super) fn cancel_rows(&self) -> &'a [Le] {
        self.0.bytes(CANCEL).as_chunks().0
    }
}

/// Reads a pair of shapes.
pub(super) fn shapes([a, b, c, d]: &Le) -> [usize; 2] {
    [[*a, *b], [*c, *d]].map(|le| u16::from_le_bytes(le).into())
}

/// Counts of a prior. The length of every section follows from the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PriorCounts {
    /// The skin's row in the part table.
    pub skin: u32,
    /// Shapes of the skin, S.
    pub shape_len: u32,
    /// Pairs of mirrored shapes.
    pub symmetry_len: u32,
    /// Pairs of mutually exclusive shapes.
    pub cancel_len: u32,
}

flat! { PriorCounts of "prior_counts", words, from_words: [u32; 4] {
    skin, shape_len, symmetry_len, cancel_len
} }

impl PriorCounts {
    /// Computes a section's length in bytes, or the least length of the names; `None` if priors
    /// lack the section.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the requirements for the sections, in the terms of [`RULES`].
    pub(crate) const fn asked(&self) -> Asked {
        let Self { shape_len: s, symmetry_len: y, cancel_len: c, .. } = *self;
        // Larger counts than the format allows are refused before this value matters.
        let shapes = if s > u16::MAX as u32 { 0 } else { s };
        Asked::new(ALWAYS, [1, s, packed_len(shapes as usize) as u32, y, c])
    }
}

/// Default stiffness of pins, and measured accuracy of a prior. Lengths are in the file's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct PriorFit {
    /// β, the squared distance by which a pin may miss.
    pub beta: f32,
    /// Training frames of the prior; 0 if the prior was not trained.
    pub frames: f32,
    /// RMS distance over the vertices of held-out frames, with the maker's set of pins; 0 if not
    /// measured.
    pub error: f32,
    /// RMS distance for the prior without covariance; 0 if not measured.
    pub slider_error: f32,
}

flat! { PriorFit of "prior_fit", figures, from_figures: [f32; 4] {
    beta, frames, error, slider_error
} }

/// Indices of the counts in their section.
mod place {
    pub(super) const SKIN: usize = 0;
    pub(super) const SHAPES: usize = 1;
}

/// The sections of a prior, in the trainer's order.
pub const PRIOR_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && PriorCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of a prior. Sizes: 1, S, S (S + 1) / 2, mirrored pairs, exclusive pairs.
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

/// Checks a prior's counts, and returns the requirements for its sections.
///
/// - `part_len`: parts of the file.
/// - `shape_len`: returns the number of shapes of a part if the part is a skin.
pub(crate) fn check_counts(
    words: &[u32; COUNTS],
    loading: &Loading<'_>,
    part_len: usize,
    shape_len: impl Fn(u16) -> Option<u32>,
) -> Checked<Asked> {
    let section = SectionKind::PriorCounts;
    let counts = PriorCounts::from_words(first_counts(words));
    let most = loading.limits.shapes.min(u16::MAX.into());
    content::check_counts(loading, section, words, &[(place::SHAPES, 1, most)])?;
    let Some(expected) = u16::try_from(counts.skin).ok().and_then(shape_len) else {
        let values = [part_len as u32, counts.skin];
        return Err(loading.refuse(Kind::Index, Some(section), place::SKIN, values));
    };
    if expected != counts.shape_len {
        let values = [expected, counts.shape_len];
        return Err(loading.refuse(Kind::Mismatch, Some(section), place::SHAPES, values));
    }
    Ok(counts.asked())
}

/// Checks the content of a prior. The lengths of all sections have been checked before.
pub(crate) fn check_content(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(prior, loading))
}

/// The checks of the content, in order. A table keeps code small, as for an envelope.
static CHECKS: [fn(&Prior<'_>, &Loading<'_>) -> Checked; 7] = [
    |prior, loading| content::check_names(loading, prior.names()),
    |prior, loading| content::check_floats(loading, &prior.0, &RULES),
    check_factor,
    check_bounds,
    check_symmetry,
    check_cancel_pairs,
    check_beta,
];

/// Checks that the factor's diagonal makes the precision positive, even after rounding.
fn check_factor(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    let (n, factor) = (prior.shape_len(), prior.factor());
    for (column, row) in rows(factor, n).enumerate() {
        let mut square = 0.0;
        let mut start = 0;
        for above in 0..column {
            square += squared(factor.get(start + column - above));
            start += n - above;
        }
        let diagonal = row.first();
        let own = squared(diagonal);
        let is_positive = diagonal.is_some_and(|le| f32::from_le_bytes(*le) > 0.0);
        if !is_positive || own < SHARE_MIN * (own + square) {
            let at = packed_len(n) - packed_len(n - column);
            return loading.invalid(SectionKind::PriorFactor, at);
        }
    }
    Ok(())
}

fn squared(le: Option<&Le>) -> f64 {
    let x = le.map_or(0.0, |le| f64::from(f32::from_le_bytes(*le)));
    x * x
}

/// Checks that no upper bound is below its lower bound.
fn check_bounds(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    let ends_first = |le: &[Le; 2]| {
        let [low, high] = floats(le);
        low > high
    };
    match prior.bounds().iter().position(ends_first) {
        None => Ok(()),
        Some(shape) => loading.invalid(SectionKind::WeightBounds, shape),
    }
}

/// Checks that each pair has two different shapes, and that no stiffness is negative.
fn check_symmetry(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    for (index, [pair, stiffness]) in prior.symmetry_rows().iter().enumerate() {
        check_pair(prior, loading, SectionKind::Symmetry, index, shapes(pair))?;
        if f32::from_le_bytes(*stiffness) < 0.0 {
            return loading.invalid(SectionKind::Symmetry, index);
        }
    }
    Ok(())
}

/// Checks that each pair has two different shapes whose bounds contain 0.
fn check_cancel_pairs(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    for (index, pair) in prior.cancel_rows().iter().map(shapes).enumerate() {
        check_pair(prior, loading, SectionKind::CancelPairs, index, pair)?;
        let holds = |shape: usize| {
            prior.weight_bounds(shape).is_some_and(|[low, high]| low <= 0.0 && 0.0 <= high)
        };
        if !pair.into_iter().all(holds) {
            return loading.invalid(SectionKind::CancelPairs, index);
        }
    }
    Ok(())
}

fn check_pair(
    prior: &Prior<'_>,
    loading: &Loading<'_>,
    section: SectionKind,
    index: usize,
    pair: [usize; 2],
) -> Checked {
    for shape in pair {
        content::check_index(loading, section, index, prior.counts().shape_len, shape as u32)?;
    }
    let [a, b] = pair;
    if a == b { loading.invalid(section, index) } else { Ok(()) }
}

/// Checks that β is positive.
fn check_beta(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    if prior.fit().beta > 0.0 { Ok(()) } else { loading.invalid(SectionKind::PriorFit, 0) }
}
