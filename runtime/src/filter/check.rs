//! The checks of a filter, in the order that FORMAT.md lists.

use super::counts::{FilterCounts, RULES, place};
use super::view::Filter;
use crate::format::SectionKind;
use crate::format::content::{check_counts, check_floats, check_names};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};

/// Checks a filter's counts, and returns what they ask of its sections.
pub(crate) fn counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    let section = SectionKind::FilterCounts;
    let most = u32::from(u16::MAX);
    check_counts(loading, section, words, &[(place::FACTOR, 1, most), (place::TAPS, 1, most)])?;
    let counts = FilterCounts::from_words(first_counts(words));
    if counts.tap_len.is_multiple_of(2) {
        return loading.invalid(section, place::TAPS).map(|()| counts.asked());
    }
    Ok(counts.asked())
}

/// Checks the content of a filter whose sections all have their length.
pub(crate) fn content(filter: &Filter<'_>, loading: &Loading<'_>) -> Checked {
    check_names(loading, filter.names())?;
    check_floats(loading, &filter.0, &RULES)
}
