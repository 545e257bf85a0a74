//! Small matrices and the blocked product; every sum runs left to right.

use crate::Matrix3x4;

/// A 3x3 matrix as three columns.
pub(crate) type Columns = [[f32; 3]; 3];

/// A little-endian f32 where it lies in the file.
pub(crate) type Le = [u8; 4];

/// The columns of the identity.
pub(crate) const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Reads N floats of the file.
#[inline]
pub(crate) fn floats<const N: usize>(le: &[Le; N]) -> [f32; N] {
    le.map(f32::from_le_bytes)
}

/// Returns a . b.
#[inline]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns m v.
#[inline]
pub(crate) fn transform(m: &Columns, v: [f32; 3]) -> [f32; 3] {
    let [a, b, c] = m;
    [0, 1, 2].map(|r| a[r] * v[0] + b[r] * v[1] + c[r] * v[2])
}

/// Returns transpose(m) v.
#[inline]
pub(crate) fn transform_transposed(m: &Columns, v: [f32; 3]) -> [f32; 3] {
    m.map(|column| dot(column, v))
}

/// Returns the four columns of a map.
#[inline]
pub(crate) fn columns(m: &Matrix3x4) -> [[f32; 3]; 4] {
    [0, 1, 2, 3].map(|c| [m[0][c], m[1][c], m[2][c]])
}

/// Returns the map a b: first b, then a.
#[inline]
pub(crate) fn compose(a: &Matrix3x4, b: &Matrix3x4) -> Matrix3x4 {
    a.map(|row| {
        let mut out = [0, 1, 2, 3].map(|c| row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c]);
        out[3] += row[3];
        out
    })
}

/// Adds to 8 rows of 3 sums the product of one block of 8 rows with its input.
///
/// `block` holds 8 coefficients a column, `input` three coordinates a column, `sums[r][i]` is row
/// i's coordinate r. Each sum takes its columns in order, whatever the SIMD width.
#[inline]
pub(crate) fn add_block_product(sums: &mut [[f32; 8]; 3], block: &[[Le; 8]], input: &[[f32; 3]]) {
    let mut local = *sums;
    for (coefficients, x) in block.iter().zip(input) {
        let coefficients = floats(coefficients);
        for (sum, x) in local.iter_mut().zip(x) {
            for (sum, coefficient) in sum.iter_mut().zip(coefficients) {
                *sum += coefficient * x;
            }
        }
    }
    *sums = local;
}
