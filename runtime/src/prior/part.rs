//! A prior in a loaded file: its counts, its sections, its accessors, and the checks of its content.

use super::packed::{packed_len, rows};
use crate::format::content;
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

/// The least share of a weight's precision that the other weights may leave on the factor's diagonal: rounding in f64
/// stays far below it, so that every prior has a factor with any pins. A floor of 0.1 leaves 2e-3 of 53 shapes.
const SHARE_MIN: f64 = 1.0e-10;

/// Mean and precision of the weights of a skin's S shapes; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Prior<'a>(pub(crate) Part<'a>);

part::view! { Prior, PriorLayout, |words| -> PriorCounts { PriorCounts::from_words(first_counts(words)) } }

impl<'a> Prior<'a> {
    /// Returns S, the number of shapes.
    pub const fn shape_len(&self) -> usize {
        self.counts().shape_len as usize
    }

    /// Returns the mean weight of a shape.
    pub fn mean(&self, shape: usize) -> Option<f32> {
        self.means().get(shape).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns an entry of U, whose square Uᵀ U is the precision; 0 below the diagonal.
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

    /// Lists the pairs of shapes that mirror each other, each with its stiffness: the reciprocal of the mean square by
    /// which they differ.
    pub fn symmetry(&self) -> impl Iterator<Item = ([usize; 2], f32)> + use<'a> {
        self.symmetry_rows()
            .iter()
            .map(|[pair, stiffness]| (shapes(pair), f32::from_le_bytes(*stiffness)))
    }

    /// Lists the pairs of shapes of which one alone is at work.
    pub fn cancel_pairs(&self) -> impl Iterator<Item = [usize; 2]> + use<'a> {
        self.cancel_rows().iter().map(shapes)
    }

    /// Returns how stiff pins are by default, and what the prior was measured to reach.
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
mod place {
    pub(super) const SKIN: usize = 0;
    pub(super) const SHAPES: usize = 1;
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

/// Checks a prior's counts, and returns what they ask of its sections.
///
/// - `part_len`: parts of the file.
/// - `shape_len`: counts the shapes of a part, if that is a skin.
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

/// Checks the content of a prior whose sections all have their length.
pub(crate) fn check_content(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(prior, loading))
}

/// The checks of the content, in their order, likewise as an envelope's.
static CHECKS: [fn(&Prior<'_>, &Loading<'_>) -> Checked; 7] = [
    |prior, loading| content::check_names(loading, prior.names()),
    |prior, loading| content::check_floats(loading, &prior.0, &RULES),
    check_factor,
    check_bounds,
    check_symmetry,
    check_cancel_pairs,
    check_beta,
];

/// Checks that the factor has a diagonal that makes the precision positive, also after rounding.
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

/// Checks that no bound ends before it starts.
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

/// Checks that pairs are of two shapes, and that their stiffness is not negative.
fn check_symmetry(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    for (index, [pair, stiffness]) in prior.symmetry_rows().iter().enumerate() {
        check_pair(prior, loading, SectionKind::Symmetry, index, shapes(pair))?;
        if f32::from_le_bytes(*stiffness) < 0.0 {
            return loading.invalid(SectionKind::Symmetry, index);
        }
    }
    Ok(())
}

/// Checks that pairs are of two shapes, both of which may be 0.
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

/// Checks that pins have a stiffness.
fn check_beta(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    if prior.fit().beta > 0.0 { Ok(()) } else { loading.invalid(SectionKind::PriorFit, 0) }
}
