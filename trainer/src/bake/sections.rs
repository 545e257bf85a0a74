//! Encoders and checks for the contents of sections.

use crate::Error;
use faer::{Mat, MatRef};
use half::f16;
use sinew_runtime::format::SectionKind;

/// Sections of a part: kind, whether a reader must know the section, and content.
pub type Sections = Vec<(SectionKind, bool, Vec<u8>)>;

/// Writes the end offset of each name, then all names.
pub(crate) fn names<'a>(all: impl Iterator<Item = &'a String>) -> Result<Vec<u8>, Error> {
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

/// Writes a matrix in blocks of 8 rows, each column-major; zeros pad the last block.
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

/// Writes numbers in half precision; numbers below the smallest normal one become 0.
pub(crate) fn halves(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(|x| half(x).to_le_bytes()).collect()
}

/// Rounds a number to half precision; a number below the smallest normal one becomes 0.
pub(crate) fn half(x: f64) -> f16 {
    let half = f16::from_f64_const(x);
    if half.is_normal() || half.is_infinite() || half.is_nan() { half } else { f16::ZERO }
}

/// Checks that an array has the length that other arrays imply.
pub(crate) fn check_len(what: &str, expected: usize, found: usize) -> Result<(), Error> {
    if found == expected {
        return Ok(());
    }
    Err(Error::mismatch(format!("{what}: expected {expected} elements, found {found}")))
}

/// Checks the rows and columns of a matrix against expected counts; `what` names both.
pub(crate) fn check_shape(
    what: [&str; 2],
    expected: [usize; 2],
    found: &Mat<f64>,
) -> Result<(), Error> {
    check_len(what[0], expected[0], found.nrows())?;
    check_len(what[1], expected[1], found.ncols())
}

/// Converts a count or an index, called `what`, to the type of its field in the file.
pub(crate) fn narrow<T: TryFrom<usize>>(what: &str, found: usize) -> Result<T, Error> {
    T::try_from(found).map_err(|_| Error::limit(format!("{what}: {found} does not fit the file")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest_of_ieee_754_without_subnormal_ones() {
        for (number, bits) in [
            (0.0, 0),
            (1.0, 0x3c00_u16),
            (-2.0, 0xc000),
            (1.0 / 3.0, 0x3555),
            (65_504.0, 0x7bff),
            (2.0_f64.powi(-14), 0x0400),
            (-(2.0_f64.powi(-15)), 0),
            // Half-way between two numbers: rounds to even.
            (1.0 + 2.0_f64.powi(-11), 0x3c00),
            (1.0 + 3.0 * 2.0_f64.powi(-11), 0x3c02),
        ] {
            assert_eq!(halves([number]), bits.to_le_bytes(), "{number}");
        }
    }
}
