//! The checks of a kernel, in the order of FORMAT.md.

use super::counts::{KernelCounts, NO_TERM, RULES, place};
use super::rows::{InputRow, OutputRow};
use super::rule::KernelRule;
use super::view::KernelMap;
use crate::format::content::{check_counts, check_floats, check_index, check_names};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::{FileErrorKind as Kind, SectionKind, saturated};
use crate::linear::floats;

/// Checks a kernel's counts, and returns the requirements for its sections.
pub(crate) fn counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    // Terms and their inputs are u16 with the greatest value reserved. Other counts need no more.
    let most = u32::from(u16::MAX);
    let ranges = [
        (place::INPUTS, 1, most),
        (place::OUTPUTS, 1, most),
        (place::FEATURES, 1, most),
        (place::METRIC, 0, most),
        (place::CENTRES, 0, most),
        (place::TERMS, 0, most),
        (place::VALUES, 1, most),
        (place::VARIANCE, 0, most),
    ];
    check_counts(loading, SectionKind::KernelCounts, words, &ranges)?;
    Ok(KernelCounts::from_words(first_counts(words)).asked())
}

/// Checks the content of a kernel. The lengths of all sections have been checked before.
pub(crate) fn content(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(map, loading))
}

/// The checks of the content, in order. A table keeps code small, as for an envelope.
static CHECKS: [fn(&KernelMap<'_>, &Loading<'_>) -> Checked; 7] = [
    |map, loading| check_names(loading, map.names()),
    |map, loading| check_floats(loading, &map.0, &RULES),
    check_rule,
    check_inputs,
    check_outputs,
    check_features,
    check_terms,
];

/// Checks that the numbers of the rule are known, and that a fade starts before it ends.
fn check_rule(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::KernelRule;
    let bytes = map.rule_bytes().first_chunk().copied().unwrap_or_default();
    match KernelRule::from_bytes(&bytes) {
        Ok(rule) if rule.is_sound() => Ok(()),
        Ok(_) => loading.invalid(section, 0),
        Err(number) => unknown(loading, section, 0, number),
    }
}

/// Checks that inputs are known, that axes have length 1, and that the features add up to their
/// count.
fn check_inputs(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Inputs;
    let mut features = 0;
    for (index, row) in map.input_rows().iter().enumerate() {
        match InputRow::from_bytes(row) {
            Ok(input) if input.is_sound() => features += input.kind.feature_len() as u64,
            Ok(_) => return loading.invalid(section, index),
            Err(number) => return unknown(loading, section, index, number),
        }
    }
    check_sum(loading, place::FEATURES, features, map.counts().feature_len)
}

/// Checks that outputs are known, that ranges and neutral values fit their kinds, and that the
/// values add up to their count.
fn check_outputs(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Outputs;
    let mut values = 0;
    for (index, row) in map.output_rows().iter().enumerate() {
        match OutputRow::from_bytes(row) {
            Ok(output) if output.is_sound() => values += output.kind.value_len() as u64,
            Ok(_) => return loading.invalid(section, index),
            Err(number) => return unknown(loading, section, index, number),
        }
    }
    check_sum(loading, place::VALUES, values, map.counts().value_len)
}

/// Checks that no feature's range ends before it starts.
fn check_features(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    for (index, figures) in map.features().iter().enumerate() {
        let [_, _, low, high] = floats(figures);
        if low > high {
            return loading.invalid(SectionKind::Features, index);
        }
    }
    Ok(())
}

/// Checks that the first term is 1, and that every other term is the product of an earlier term and
/// a feature.
fn check_terms(map: &KernelMap<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Terms;
    let features = map.counts().feature_len;
    for (index, term) in map.terms().iter().enumerate() {
        let [earlier, input] = term.map(u16::from_le_bytes);
        if index == 0 {
            if [earlier, input] != [NO_TERM; 2] {
                return loading.invalid(section, 0);
            }
            continue;
        }
        check_index(loading, section, 2 * index, index as u32, earlier.into())?;
        check_index(loading, section, 2 * index + 1, features, input.into())?;
    }
    Ok(())
}

/// Refuses a number that this reader does not know.
fn unknown(loading: &Loading<'_>, section: SectionKind, index: usize, number: u8) -> Checked {
    Err(loading.refuse(Kind::Unsupported, Some(section), index, [0, number.into()]))
}

/// Checks a count against the sum over its rows.
fn check_sum(loading: &Loading<'_>, place: usize, expected: u64, found: u32) -> Checked {
    let expected = saturated(expected);
    if expected == found {
        return Ok(());
    }
    Err(loading.refuse(Kind::Mismatch, Some(SectionKind::KernelCounts), place, [expected, found]))
}
