//! The checks of a prior, in the order that FORMAT.md lists.

use super::counts::{PriorCounts, RULES, place};
use super::packed::{packed_len, rows};
use super::view::{Prior, shapes};
use crate::format::content::{check_counts, check_floats, check_index, check_names};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::{FileErrorKind as Kind, SectionKind};
use crate::linear::{Le, floats};

/// The least share of a weight's precision that the other weights may leave on the factor's diagonal: rounding in f64
/// stays far below it, so that every prior has a factor with any pins. A floor of 0.1 leaves 2e-3 of 53 shapes.
const SHARE_MIN: f64 = 1.0e-10;

/// Checks a prior's counts, and returns what they ask of its sections.
///
/// - `part_len`: parts of the file.
/// - `shape_len`: counts the shapes of a part, if that is a skin.
pub(crate) fn counts(
    words: &[u32; COUNTS],
    loading: &Loading<'_>,
    part_len: usize,
    shape_len: impl Fn(u16) -> Option<u32>,
) -> Checked<Asked> {
    let section = SectionKind::PriorCounts;
    let counts = PriorCounts::from_words(first_counts(words));
    let most = loading.limits.shapes.min(u16::MAX.into());
    check_counts(loading, section, words, &[(place::SHAPES, 1, most)])?;
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
pub(crate) fn content(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(prior, loading))
}

/// The checks of the content, in their order, likewise as an envelope's.
static CHECKS: [fn(&Prior<'_>, &Loading<'_>) -> Checked; 7] = [
    |prior, loading| check_names(loading, prior.names()),
    |prior, loading| check_floats(loading, &prior.0, &RULES),
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
        check_index(loading, section, index, prior.counts().shape_len, shape as u32)?;
    }
    let [a, b] = pair;
    if a == b { loading.invalid(section, index) } else { Ok(()) }
}

/// Checks that pins have a stiffness.
fn check_beta(prior: &Prior<'_>, loading: &Loading<'_>) -> Checked {
    if prior.fit().beta > 0.0 { Ok(()) } else { loading.invalid(SectionKind::PriorFit, 0) }
}
