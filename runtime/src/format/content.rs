//! Checks that every part's content shares.

use super::error::{FileError, FileErrorKind as Kind, saturated};
use super::manifest::Span;
use super::rule::Rule;
use super::tables::SectionKind;
use core::ops::RangeInclusive;

/// Checks that the floats of a part's sections are within what its rules say.
#[inline(never)]
pub(crate) fn check_floats(file: &[u8], rules: &[Rule], spans: &[Span]) -> Result<(), FileError> {
    for (rule, span) in rules.iter().zip(spans) {
        let Some(floats) = rule.floats else { continue };
        if let Some(index) = outside(span.bytes(file).as_chunks().0, floats.range()) {
            return Err(FileError::of(Kind::Float, rule.section, index, [0; 2]));
        }
    }
    Ok(())
}

/// Checks a count of a section, by its place there.
#[inline(never)]
pub(crate) fn check_count(
    section: SectionKind,
    index: usize,
    range: RangeInclusive<u32>,
    found: u32,
) -> Result<(), FileError> {
    let (least, most) = range.into_inner();
    let kind = if found > most { Kind::Limit } else { Kind::Empty };
    if least <= found && found <= most {
        return Ok(());
    }
    let expected = if found > most { most } else { least };
    Err(FileError::of(kind, section, index, [expected, found]))
}

/// Finds the first float that is not within `[least, greatest]`, as none is that is no number.
#[inline(never)]
pub(crate) fn outside(floats: &[[u8; 4]], [least, greatest]: [f32; 2]) -> Option<usize> {
    let within = |x: f32| least <= x && x <= greatest;
    floats.iter().position(|le| !within(f32::from_le_bytes(*le)))
}

/// Checks that element `index` of a section points to less than `below`.
pub(crate) fn check_index(
    section: SectionKind,
    index: usize,
    below: usize,
    found: usize,
) -> Result<(), FileError> {
    if found < below {
        return Ok(());
    }
    let values = [below as u64, found as u64].map(saturated);
    Err(FileError::of(Kind::Index, section, index, values))
}

/// Refuses an element that breaks a rule of its section.
pub(crate) fn invalid(section: SectionKind, index: usize) -> Result<(), FileError> {
    Err(FileError::of(Kind::Invalid, section, index, [0; 2]))
}
