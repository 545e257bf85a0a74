//! Small matrices and the blocked product; every sum runs left to right.
//!
//! Loops run over zipped rows, not over indices. In code optimised for size an index keeps its
//! bounds check, and the check would put a panic into firmware.

use crate::lanes::{Lanes, Real, Unit};
use crate::unit::{Level, by_unit};

/// A rigid or affine transform as three rows of four: `y[r] = m[r][0..3] . x + m[r][3]`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// A 3x3 matrix as three columns.
pub(crate) type Columns = [[f32; 3]; 3];

/// A little-endian f32 in the file's bytes.
pub(crate) type Le = [u8; 4];

/// The columns of the identity.
pub(crate) const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Reads N floats from the file.
#[inline]
pub(crate) fn floats<const N: usize>(le: &[Le; N]) -> [f32; N] {
    le.map(f32::from_le_bytes)
}

/// Returns a . b.
#[cfg_attr(not(target_os = "none"), inline(always))]
pub(crate) fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns a x b.
#[cfg_attr(not(target_os = "none"), inline(always))]
pub(crate) fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a + b.
#[inline]
pub(crate) fn sum([x, y, z]: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [x + b[0], y + b[1], z + b[2]]
}

/// Returns the squared length of a quaternion x, y, z, w.
pub(crate) fn squared_length([x, y, z, w]: [f32; 4]) -> f32 {
    dot([x, y, z], [x, y, z]) + w * w
}

/// Returns the rows of the rotation of a quaternion x, y, z, w of any length but 0. Dividing by the
/// squared length normalises the quaternion.
pub(crate) fn turn(q: [f32; 4]) -> [[f32; 3]; 3] {
    let [x, y, z, w] = q;
    let s = 2.0 / squared_length(q);
    let (xs, ys, zs) = (x * s, y * s, z * s);
    [
        [1.0 - (y * ys + z * zs), x * ys - w * zs, x * zs + w * ys],
        [x * ys + w * zs, 1.0 - (x * xs + z * zs), y * zs - w * xs],
        [x * zs - w * ys, y * zs + w * xs, 1.0 - (x * xs + y * ys)],
    ]
}

/// Returns a b.
pub(crate) fn product(a: &Columns, [x, y, z]: &Columns) -> Columns {
    [transform(a, *x), transform(a, *y), transform(a, *z)]
}

/// Returns m v.
#[inline]
pub(crate) fn transform([a, b, c]: &Columns, [x, y, z]: [f32; 3]) -> [f32; 3] {
    let row = |i: usize| a[i] * x + b[i] * y + c[i] * z;
    [row(0), row(1), row(2)]
}

/// Replaces each column v by transpose(m) v.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn turn_back([a, b, c]: &Columns, columns: &mut [[f32; 3]]) {
    for column in columns {
        *column = [dot(*a, *column), dot(*b, *column), dot(*c, *column)];
    }
}

/// Returns the four columns of a transform.
#[inline]
pub(crate) fn columns(m: &Matrix3x4) -> [[f32; 3]; 4] {
    let [[x0, y0, z0, w0], [x1, y1, z1, w1], [x2, y2, z2, w2]] = *m;
    [[x0, x1, x2], [y0, y1, y2], [z0, z1, z2], [w0, w1, w2]]
}

/// Transforms a point.
#[inline]
pub(crate) fn moved(m: &Matrix3x4, [x, y, z]: [f32; 3]) -> [f32; 3] {
    m.map(|[a, b, c, shift]| a * x + b * y + c * z + shift)
}

/// Composes two transforms: a b, which applies b first.
#[inline]
pub fn compose(a: &Matrix3x4, [x, y, z]: &Matrix3x4) -> Matrix3x4 {
    let mut out = [[0.0; 4]; 3];
    for (row, [a0, a1, a2, shift]) in out.iter_mut().zip(a) {
        for (((out, x), y), z) in row.iter_mut().zip(x).zip(y).zip(z) {
            *out = a0 * x + a1 * y + a2 * z;
        }
        row[3] += shift;
    }
    out
}

/// Inverts a transform. The result is not finite if the determinant is 0.
pub fn inverse(m: &Matrix3x4) -> Matrix3x4 {
    let [[x0, x1, x2, tx], [y0, y1, y2, ty], [z0, z1, z2, tz]] = *m;
    let (x, y, z) = ([x0, x1, x2], [y0, y1, y2], [z0, z1, z2]);
    let [a, b, c] = [cross(y, z), cross(z, x), cross(x, y)];
    let scale = 1.0 / dot(a, x);
    let row = |r: [f32; 3]| {
        let [r0, r1, r2] = r.map(|value| value * scale);
        [r0, r1, r2, -(r0 * tx + r1 * ty + r2 * tz)]
    };
    let ([a0, a1, a2], [b0, b1, b2], [c0, c1, c2]) = (a, b, c);
    [row([a0, b0, c0]), row([a1, b1, c1]), row([a2, b2, c2])]
}

/// Returns the unnormalised quaternion of a rotation: x, y, z, and w, which is not negative.
///
/// Computed from the largest of the four components (Shepperd 1978).
#[inline(always)]
pub(crate) fn quaternion(m: &Columns) -> ([f32; 3], f32) {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = *m;
    let (v, w) = if xx + yy + zz >= 0.0 {
        ([zy - yz, xz - zx, yx - xy], 1.0 + (xx + yy + zz))
    } else if xx >= yy && xx >= zz {
        ([1.0 + (xx - yy - zz), xy + yx, xz + zx], zy - yz)
    } else if yy >= zz {
        ([xy + yx, 1.0 + (yy - xx - zz), yz + zy], xz - zx)
    } else {
        ([xz + zx, yz + zy, 1.0 + (zz - xx - yy)], yx - xy)
    };
    let [x, y, z] = v;
    if w < 0.0 { ([-x, -y, -z], -w) } else { (v, w) }
}

/// Adds the product of one block of 8 rows with its input to 8 rows of 3 sums.
///
/// `block` holds 8 coefficients per column and `input` three coordinates per column. `sums[r][i]`
/// is coordinate r of row i. Each sum takes its columns in order, for any SIMD width.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn add_block_product(
    level: Level,
    sums: &mut [[f32; 8]; 3],
    block: &[[Le; 8]],
    input: &[[f32; 3]],
) {
    if cfg!(target_os = "none") {
        // Row after row, with the sums in registers.
        (0..8).for_each(|row| add_row_product(row, sums, block, input));
        return;
    }
    by_unit!(level, unit => {
        let [x, y, z] = &*sums;
        let mut local = [unit.load(x), unit.load(y), unit.load(z)];
        for (coefficients, x) in block.iter().zip(input) {
            let coefficients = unit.read(coefficients);
            for (sum, x) in local.iter_mut().zip(x) {
                for (sum, coefficient) in sum.iter_mut().zip(coefficients) {
                    *sum += coefficient * *x;
                }
            }
        }
        for (sums, local) in sums.iter_mut().zip(&local) {
            *sums = unit.floats(*local);
        }
    });
}

/// Adds the product of one row, as [`add_block_product`] does.
#[inline(never)]
fn add_row_product(
    row: usize,
    [out_x, out_y, out_z]: &mut [[f32; 8]; 3],
    block: &[[Le; 8]],
    input: &[[f32; 3]],
) {
    let row = row % 8;
    let (mut sum_x, mut sum_y, mut sum_z) = (out_x[row], out_y[row], out_z[row]);
    for (coefficients, [x, y, z]) in block.iter().zip(input) {
        let coefficient = f32::from_le_bytes(coefficients[row]);
        sum_x += coefficient * x;
        sum_y += coefficient * y;
        sum_z += coefficient * z;
    }
    (out_x[row], out_y[row], out_z[row]) = (sum_x, sum_y, sum_z);
}

/// Computes the product of a matrix in blocks of 8 rows with a vector in two parts. Two blocks run
/// at a time, to hide the latency of the additions.
///
/// `matrix` holds 8 coefficients per column, one block after the other; `out[b]` receives the
/// product of block b.
pub(crate) fn block_product(
    level: Level,
    matrix: &[[Le; 8]],
    [first, second]: [&[f32]; 2],
    out: &mut [[f32; 8]],
) {
    by_unit!(level, unit => {
        // A chunk length of zero would panic.
        let mut blocks = matrix.chunks_exact((first.len() + second.len()).max(1));
        for out in out.chunks_mut(2) {
            let Some(a) = blocks.next() else { return };
            let b = blocks.next().unwrap_or(a);
            let cut = first.len().min(a.len()).min(b.len());
            let ((a0, a1), (b0, b1)) = (a.split_at(cut), b.split_at(cut));
            let mut sums = [unit.load(&[0.0; 8]); 2];
            add_products(unit, &mut sums, [a0, b0], first);
            add_products(unit, &mut sums, [a1, b1], second);
            for (out, sums) in out.iter_mut().zip(&sums) {
                *out = unit.floats(*sums);
            }
        }
    });
}

#[inline(always)]
fn add_products<U: Unit>(
    unit: U,
    sums: &mut [Lanes<U>; 2],
    [a, b]: [&[[Le; 8]]; 2],
    input: &[f32],
) {
    let [mut sums_a, mut sums_b] = *sums;
    for ((a, b), x) in a.iter().zip(b).zip(input) {
        for (sum, coefficient) in sums_a.iter_mut().zip(unit.read(a)) {
            *sum += coefficient * *x;
        }
        for (sum, coefficient) in sums_b.iter_mut().zip(unit.read(b)) {
            *sum += coefficient * *x;
        }
    }
    *sums = [sums_a, sums_b];
}

/// Sums over the coordinates of a point x and of points.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sum {
    /// The squared distance from points t, `|x - t|²`.
    Squared,
    /// Its excess over the origin's, `|x - t|² - |t|² = x (x - 2 t)`, with the last places of a short x. The points are
    /// 2 t.
    Gain,
}

/// Computes sums for points in blocks of 8. Coordinates are summed in order, and two blocks run at a time, as in
/// [`block_product`].
pub(crate) fn block_sums(
    level: Level,
    kind: Sum,
    points: &[[Le; 8]],
    from: &[f32],
    out: &mut [[f32; 8]],
) {
    by_unit!(level, unit => match kind {
        _ if cfg!(target_os = "none") => sums_of(unit, kind, points, from, out),
        Sum::Squared => sums_of(unit, Sum::Squared, points, from, out),
        Sum::Gain => sums_of(unit, Sum::Gain, points, from, out),
    });
}

#[inline(always)]
fn sums_of<U: Unit>(unit: U, kind: Sum, points: &[[Le; 8]], from: &[f32], out: &mut [[f32; 8]]) {
    // A chunk length of zero would panic.
    let mut blocks = points.chunks_exact(from.len().max(1));
    for out in out.chunks_mut(2) {
        let Some(a) = blocks.next() else { return };
        let b = blocks.next().unwrap_or(a);
        let [mut sums_a, mut sums_b] = [unit.load(&[0.0; 8]); 2];
        for ((a, b), &x) in a.iter().zip(b).zip(from) {
            kind.add::<U>(&mut sums_a, x, unit.read(a));
            kind.add::<U>(&mut sums_b, x, unit.read(b));
        }
        for (out, sums) in out.iter_mut().zip(&[sums_a, sums_b]) {
            *out = unit.floats(*sums);
        }
    }
}

impl Sum {
    #[inline(always)]
    fn add<U: Unit>(self, sums: &mut Lanes<U>, x: f32, t: Lanes<U>) {
        for (sum, t) in sums.iter_mut().zip(t) {
            let apart = t.splat(x) - t;
            *sum += match self {
                Self::Squared => apart * apart,
                Self::Gain => apart * x,
            };
        }
    }
}

/// Returns a number of rows, rounded up to whole blocks of 8.
pub(crate) const fn padded(len: usize) -> usize {
    len.next_multiple_of(8)
}

/// Reads an entry of a matrix stored in blocks of 8 rows, each block column-major.
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

/// Splits N = R C floats into R rows.
pub(crate) fn rows<const N: usize, const C: usize, const R: usize>(
    flat: &[f32; N],
) -> [[f32; C]; R] {
    const { assert!(N == R * C) };
    let mut out = [[0.0; C]; R];
    for (row, values) in out.iter_mut().zip(flat.as_chunks().0) {
        *row = *values;
    }
    out
}

/// Splits memory at a length that was checked before; never panics.
pub(crate) fn split<T>(memory: &mut [T], len: usize) -> (&mut [T], &mut [T]) {
    memory.split_at_mut(len.min(memory.len()))
}
