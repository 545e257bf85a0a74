//! Checks that all kinds of parts share.

use super::error::FileErrorKind as Kind;
use super::part::Part;
use super::refusal::{Checked, Loading};
use super::rule::Rule;
use super::sections::SectionKind;
use crate::names::Names;

/// Checks the names of a part.
pub(crate) fn check_names(loading: &Loading<'_>, names: Names<'_>) -> Checked {
    names.first_invalid().map_or(Ok(()), |index| loading.invalid(SectionKind::Names, index))
}

/// Checks that the floats in a part's sections lie within the ranges of its rules.
#[inline(never)]
pub(crate) fn check_floats(loading: &Loading<'_>, part: &Part<'_>, rules: &[Rule]) -> Checked {
    for (place, rule) in rules.iter().enumerate() {
        let Some(floats) = rule.floats else { continue };
        let (words, after) = (part.bytes(place).as_chunks().0, usize::from(floats.after));
        // A section of only floats is one element.
        let each = if after == 0 { words.len() } else { usize::from(rule.each) / 4 };
        for (element, words) in words.chunks(each.max(1)).enumerate() {
            if let Some(at) = outside(words.get(after..).unwrap_or_default(), floats.range()) {
                let index = element * (each - after) + at;
                return Err(loading.refuse(Kind::Float, Some(rule.section), index, [0; 2]));
            }
        }
    }
    Ok(())
}

/// Checks counts of a section. Each range is a place, the least and the greatest value.
#[inline(never)]
pub(crate) fn check_counts(
    loading: &Loading<'_>,
    section: SectionKind,
    counts: &[u32],
    ranges: &[(usize, u32, u32)],
) -> Checked {
    for &(place, least, most) in ranges {
        let found = counts.get(place).copied().unwrap_or_default();
        let (kind, expected) =
            if found > most { (Kind::Limit, most) } else { (Kind::Empty, least) };
        if found < least || found > most {
            return Err(loading.refuse(kind, Some(section), place, [expected, found]));
        }
    }
    Ok(())
}

/// Finds the first float outside `[least, greatest]`. NaN counts as outside.
#[inline(never)]
pub(crate) fn outside(floats: &[[u8; 4]], [least, greatest]: [f32; 2]) -> Option<usize> {
    let within = |x: f32| least <= x && x <= greatest;
    floats.iter().position(|le| !within(f32::from_le_bytes(*le)))
}

/// Checks that element `index` of a section is an index less than `below`.
pub(crate) fn check_index(
    loading: &Loading<'_>,
    section: SectionKind,
    index: usize,
    below: u32,
    found: u32,
) -> Checked {
    if found < below {
        return Ok(());
    }
    Err(loading.refuse(Kind::Index, Some(section), index, [below, found]))
}
