//! Contents of sections: what every part writes them of.

use super::error::BakeError;
use sinew_runtime::format::SectionKind;

/// The sections of a part: kind, whether a reader must know it, and content.
pub(super) type Sections = Vec<(SectionKind, bool, Vec<u8>)>;

/// Writes the end of each name, then the names.
pub(super) fn names<'a>(all: impl Iterator<Item = &'a String>) -> Result<Vec<u8>, BakeError> {
    let (mut ends, mut text) = (Vec::new(), Vec::<u8>::new());
    for name in all {
        text.extend(name.as_bytes());
        ends.extend(narrow::<u32>("name bytes", text.len())?.to_le_bytes());
    }
    ends.extend(text);
    Ok(ends)
}

pub(super) fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Cuts a row-major matrix into blocks of 8 rows, column-major, the last padded with zeros.
pub(super) fn blocks(matrix: &[f64], column_len: usize) -> Vec<u8> {
    let mut out = Vec::new();
    for block in matrix.chunks(8 * column_len.max(1)) {
        for column in 0..column_len {
            let rows = (0..8).map(|row| block.get(row * column_len + column).copied());
            out.extend(floats(&rows.map(Option::unwrap_or_default).collect::<Vec<_>>()));
        }
    }
    out
}

pub(super) fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect()
}

pub(super) fn check_len(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), BakeError> {
    if found == expected { Ok(()) } else { Err(BakeError::Length { what, expected, found }) }
}

pub(super) fn narrow<T: TryFrom<usize>>(what: &'static str, found: usize) -> Result<T, BakeError> {
    T::try_from(found).map_err(|_| BakeError::Size { what, found })
}
