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

/// Computes the product of a matrix in blocks of 8 rows with a vector in two parts.
///
/// `matrix` holds 8 coefficients a column, block after block; `out[b]` is what block b gives.
#[inline]
pub(crate) fn block_product(matrix: &[[Le; 8]], parts: [&[f32]; 2], out: &mut [[f32; 8]]) {
    let [first, second] = parts;
    for_pairs(matrix, first.len() + second.len(), out, |[a, b]| {
        let cut = first.len().min(a.len()).min(b.len());
        let ((a0, a1), (b0, b1)) = (a.split_at(cut), b.split_at(cut));
        let mut sums = [[0.0; 8]; 2];
        add_products(&mut sums, [a0, b0], first);
        add_products(&mut sums, [a1, b1], second);
        sums
    });
}

#[inline(always)]
fn add_products(sums: &mut [[f32; 8]; 2], [a, b]: [&[[Le; 8]]; 2], input: &[f32]) {
    let [mut sums_a, mut sums_b] = *sums;
    for ((a, b), x) in a.iter().zip(b).zip(input) {
        for (sum, coefficient) in sums_a.iter_mut().zip(floats(a)) {
            *sum += coefficient * x;
        }
        for (sum, coefficient) in sums_b.iter_mut().zip(floats(b)) {
            *sum += coefficient * x;
        }
    }
    *sums = [sums_a, sums_b];
}

/// Computes the squared distances of a point from points in blocks of 8, coordinate by coordinate.
#[inline]
pub(crate) fn block_squared_distances(points: &[[Le; 8]], from: &[f32], out: &mut [[f32; 8]]) {
    for_pairs(points, from.len(), out, |[a, b]| {
        let [mut sums_a, mut sums_b] = [[0.0; 8]; 2];
        for ((a, b), x) in a.iter().zip(b).zip(from) {
            for (sum, t) in sums_a.iter_mut().zip(floats(a)) {
                *sum += (x - t) * (x - t);
            }
            for (sum, t) in sums_b.iter_mut().zip(floats(b)) {
                *sum += (x - t) * (x - t);
            }
        }
        [sums_a, sums_b]
    });
}

/// Evaluates blocks of some columns two at a time, because one alone would wait for its own sums;
/// a last block without another goes with itself.
#[inline(always)]
fn for_pairs(
    blocks: &[[Le; 8]],
    column_len: usize,
    out: &mut [[f32; 8]],
    pair: impl Fn([&[[Le; 8]]; 2]) -> [[f32; 8]; 2],
) {
    // Chunks of zero would panic.
    let mut blocks = blocks.chunks_exact(column_len.max(1));
    for out in out.chunks_mut(2) {
        let Some(a) = blocks.next() else { return };
        let b = blocks.next().unwrap_or(a);
        for (out, value) in out.iter_mut().zip(pair([a, b])) {
            *out = value;
        }
    }
}

/// Reads an entry of a matrix that lies in blocks of 8 rows, each column-major.
pub(crate) fn block_entry(
    blocks: &[[Le; 8]],
    (row_len, column_len): (usize, usize),
    row: usize,
    column: usize,
) -> Option<f32> {
    if row >= row_len || column >= column_len {
        return None;
    }
    let le = blocks.get(row / 8 * column_len + column)?.get(row % 8)?;
    Some(f32::from_le_bytes(*le))
}
