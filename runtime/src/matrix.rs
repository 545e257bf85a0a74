//! Conversion of engine matrices, and the scale of an actor.
//!
//! [`Matrix3x4`] is three rows of four for column vectors: `y = m x`, the translation in the last column.
//! The memory order of an engine's sixteen floats decides the call for a 4x4 matrix:
//!
//! | engine | floats of a matrix | call |
//! |---|---|---|
//! | glam, cgmath, nalgebra, glTF, ozz-animation, OpenGL, Unity | columns, one after the other | [`from_columns`] |
//! | DirectX, XNA, USD, Unreal: rows, for row vectors (`y = x m`) | the same floats | [`from_columns`] |
//! | Blender's Python, NumPy: rows, for column vectors | rows, one after the other | [`from_rows`] |
//! | glam's `Affine3A::to_cols_array` | four columns of three | [`from_affine_columns`] |

use crate::envelope::RIGID_TOLERANCE;
use crate::linear::{Matrix3x4, columns, dot};
use crate::numeric::sqrt;

pub use crate::linear::{compose, inverse};

/// The identity transform.
pub const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Relative distance within which a scale is rounded to a number of `SCALE_BITS` bits. Single
/// precision leaves about this error in a rotation that passed down many joints.
const SCALE_TOLERANCE: f32 = 4.0e-6;
/// Bits of a scale that a person typed, for example 1, 0.5 or 1.25.
const SCALE_BITS: u32 = 12;

/// Converts a 4x4 matrix of four columns; the last row is dropped.
///
/// A row-major matrix for row vectors, as in DirectX, has the same sixteen floats.
///
/// ```
/// use sinew_runtime::matrix;
///
/// // A quarter turn about z, then two units along x, from `glam::Mat4::to_cols_array`.
/// let glam = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 1.0];
/// let rows = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
/// assert_eq!(matrix::from_columns(&glam), rows);
/// assert_eq!(matrix::to_columns(&rows), glam);
/// ```
pub const fn from_columns(m: &[f32; 16]) -> Matrix3x4 {
    let [xx, yx, zx, _, xy, yy, zy, _, xz, yz, zz, _, x, y, z, _] = *m;
    [[xx, xy, xz, x], [yx, yy, yz, y], [zx, zy, zz, z]]
}

/// Converts a 4x4 matrix of four rows for column vectors; the last row is dropped.
///
/// ```
/// use sinew_runtime::matrix;
///
/// let m = [0.0, -1.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// assert_eq!(matrix::from_rows(&m)[0], [0.0, -1.0, 0.0, 2.0]);
/// ```
pub const fn from_rows(m: &[f32; 16]) -> Matrix3x4 {
    let [xx, xy, xz, x, yx, yy, yz, y, zx, zy, zz, z, ..] = *m;
    [[xx, xy, xz, x], [yx, yy, yz, y], [zx, zy, zz, z]]
}

/// Converts an affine transform of four columns of three, as glam's `Affine3A` lists them.
///
/// ```
/// use sinew_runtime::matrix;
///
/// let glam = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0];
/// assert_eq!(matrix::from_affine_columns(&glam)[0], [0.0, -1.0, 0.0, 2.0]);
/// ```
pub const fn from_affine_columns(m: &[f32; 12]) -> Matrix3x4 {
    let [xx, yx, zx, xy, yy, zy, xz, yz, zz, x, y, z] = *m;
    [[xx, xy, xz, x], [yx, yy, yz, y], [zx, zy, zz, z]]
}

/// Converts a transform to four columns of three, as glam's `Affine3A::from_cols_array` takes them.
pub const fn to_affine_columns(m: &Matrix3x4) -> [f32; 12] {
    let [[xx, xy, xz, x], [yx, yy, yz, y], [zx, zy, zz, z]] = *m;
    [xx, yx, zx, xy, yy, zy, xz, yz, zz, x, y, z]
}

/// Converts to a 4x4 matrix of four columns, the inverse of [`from_columns`].
pub const fn to_columns(m: &Matrix3x4) -> [f32; 16] {
    let [[xx, xy, xz, x], [yx, yy, yz, y], [zx, zy, zz, z]] = *m;
    [xx, yx, zx, 0.0, xy, yy, zy, 0.0, xz, yz, zz, 0.0, x, y, z, 1.0]
}

/// Divides a pose by the uniform scale that all its joints share, and returns the scale.
///
/// A scaled actor has a pose with a scale; the divided pose is that of the actor at its own size. [`scale_palette`]
/// applies the scale again:
///
/// ```
/// use sinew_runtime::{CallError, Envelope, Matrix3x4, scale_palette, take_scale};
///
/// fn palette(
///     envelope: &Envelope<'_>,
///     pose: &mut [Matrix3x4],
///     curves: &[f32],
///     scratch: &mut [f32],
///     palette: &mut [Matrix3x4],
/// ) -> Result<f32, CallError> {
///     let scale = take_scale(pose);
///     let confidence = envelope.palette(pose, curves, scratch, palette)?;
///     scale_palette(palette, scale);
///     Ok(confidence)
/// }
/// ```
///
/// The scale is the mean length of the columns of the first joint's linear part. The columns must be equally long and
/// at right angles, within 0.2 % of the squared length: a joint that stretches or shears has no such
/// scale. A scale within 4e-6 of a number of 12 bits is rounded to that number. Without a scale, or for
/// a scale of 1, the result is 1 and the pose keeps its bits; so does a scale that is not finite or not greater than 0.
/// A scale that is a power of two is divided out and restored exactly. Normals and tangents need no correction: they
/// have length 1 for any scale of the palette.
pub fn take_scale(pose: &mut [Matrix3x4]) -> f32 {
    let first = pose.first().filter(|first| is_uniform(first));
    let scale = rounded(first.map_or(1.0, scale_of));
    if !scale.is_normal() || scale == 1.0 {
        return 1.0;
    }
    for value in pose.as_flattened_mut().as_flattened_mut() {
        *value /= scale;
    }
    scale
}

/// Scales the vertices that a palette moves, about the origin of model space.
pub fn scale_palette(palette: &mut [Matrix3x4], scale: f32) {
    for value in palette.as_flattened_mut().as_flattened_mut() {
        *value *= scale;
    }
}

/// Rounds a scale that is almost a number of few bits.
fn rounded(scale: f32) -> f32 {
    const LOST: u32 = f32::MANTISSA_DIGITS - SCALE_BITS;
    let near = scale.to_bits().wrapping_add(1 << (LOST - 1)) >> LOST << LOST;
    let near = f32::from_bits(near);
    if (scale - near).abs() <= SCALE_TOLERANCE * near { near } else { scale }
}

/// Whether the columns of a matrix are equally long and at right angles.
fn is_uniform(m: &Matrix3x4) -> bool {
    let [x, y, z, _] = columns(m);
    let square = scale_of(m) * scale_of(m);
    let near = |found: f32, expected: f32| (found - expected).abs() <= RIGID_TOLERANCE * square;
    let are_equal = [x, y, z].iter().all(|column| near(dot(*column, *column), square));
    are_equal && near(dot(x, y), 0.0) && near(dot(y, z), 0.0) && near(dot(z, x), 0.0)
}

/// Returns the scale of a matrix, as the mean over its columns.
pub(crate) fn scale_of(m: &Matrix3x4) -> f32 {
    let [x, y, z, _] = columns(m);
    sqrt((dot(x, x) + dot(y, y) + dot(z, z)) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_layout_becomes_the_same_rows() {
        let rows = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]];
        let columns = to_columns(&rows);
        assert_eq!(
            columns,
            [1.0, 5.0, 9.0, 0.0, 2.0, 6.0, 10.0, 0.0, 3.0, 7.0, 11.0, 0.0, 4.0, 8.0, 12.0, 1.0]
        );
        assert_eq!(from_columns(&columns), rows);
        let affine = [1.0, 5.0, 9.0, 2.0, 6.0, 10.0, 3.0, 7.0, 11.0, 4.0, 8.0, 12.0];
        assert_eq!(from_affine_columns(&affine), rows);
        assert_eq!(to_affine_columns(&rows), affine);
        let flat = [1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 0., 0., 0., 1.];
        assert_eq!(from_rows(&flat), rows);
    }

    #[test]
    fn a_scale_is_taken_out_and_put_back() {
        let turned = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, -0.25], [0.0, 0.0, 1.0, 3.5]];
        for scale in [0.5, 1.0, 2.0, 0.01, 8.0] {
            let mut pose = [turned, IDENTITY];
            scale_palette(&mut pose, scale);
            let scaled = pose;
            let found = take_scale(&mut pose);
            assert!((found / scale - 1.0).abs() < 1e-6, "{found} {scale}");
            assert!(scale == 0.01 || (found, pose) == (scale, [turned, IDENTITY]), "{scale}");
            scale_palette(&mut pose, found);
            for (a, b) in pose.as_flattened().iter().zip(scaled.as_flattened()) {
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs()));
            }
        }
    }

    #[test]
    fn a_pose_without_a_scale_is_unchanged() {
        let nearly = [[[1.0 + 2e-6, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]];
        for mut pose in [nearly, [[[0.0; 4]; 3]], [[[f32::MAX; 4]; 3]]] {
            let before = pose;
            assert_eq!(take_scale(&mut pose), 1.0);
            assert_eq!(pose, before);
        }
        let mut unknown = [[[f32::NAN; 4]; 3]];
        assert_eq!((take_scale(&mut unknown), take_scale(&mut [])), (1.0, 1.0));
    }

    #[test]
    fn only_a_scale_along_all_axes_is_taken_out() {
        let first = |xx, xy| [[xx, xy, 0.0, 1.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]];
        for uneven in [first(2.01, 0.0), first(1.0, 0.0), first(2.0, 0.01), first(2.0, 2.0)] {
            let mut pose = [uneven, IDENTITY];
            assert_eq!((take_scale(&mut pose), pose), (1.0, [uneven, IDENTITY]));
        }
        for nearly in [first(2.0, 0.0), first(2.002, 0.0), first(2.0, 0.002)] {
            let mut pose = [nearly, IDENTITY];
            assert!((take_scale(&mut pose) - 2.0).abs() < 1e-3);
            assert!((pose[1][0][0] - 0.5).abs() < 1e-3);
        }
    }
}
