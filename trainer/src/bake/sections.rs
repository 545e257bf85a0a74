//! Contents of sections: what every part writes them of.

use super::error::BakeError;
use faer::{Mat, MatRef};
use sinew_runtime::format::SectionKind;

/// The sections of a part: kind, whether a reader must know it, and content.
pub type Sections = Vec<(SectionKind, bool, Vec<u8>)>;

/// Writes the end of each name, then the names.
pub(crate) fn names<'a>(all: impl Iterator<Item = &'a String>) -> Result<Vec<u8>, BakeError> {
    let (mut ends, mut text) = (Vec::new(), Vec::<u8>::new());
    for name in all {
        text.extend(name.as_bytes());
        ends.extend(narrow::<u32>("name bytes", text.len())?.to_le_bytes());
    }
    ends.extend(text);
    Ok(ends)
}

pub(crate) fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Cuts a matrix into blocks of 8 rows, column-major, the last padded with zeros.
pub(crate) fn blocks(matrix: MatRef<'_, f64>) -> Vec<u8> {
    let mut out = Vec::new();
    for first in (0..matrix.nrows()).step_by(8) {
        for column in matrix.col_iter() {
            let rows = first..first + 8;
            let entry = |row| if row < matrix.nrows() { column[row] } else { 0.0 };
            out.extend(floats(&rows.map(entry).collect::<Vec<_>>()));
        }
    }
    out
}

pub(crate) fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect()
}

pub(crate) fn check_len(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), BakeError> {
    if found == expected { Ok(()) } else { Err(BakeError::Length { what, expected, found }) }
}

/// Checks the rows and columns of a matrix, by their names.
pub(crate) fn check_shape(
    what: [&'static str; 2],
    expected: [usize; 2],
    found: &Mat<f64>,
) -> Result<(), BakeError> {
    check_len(what[0], expected[0], found.nrows())?;
    check_len(what[1], expected[1], found.ncols())
}

pub(crate) fn narrow<T: TryFrom<usize>>(what: &'static str, found: usize) -> Result<T, BakeError> {
    T::try_from(found).map_err(|_| BakeError::Size { what, found })
}
