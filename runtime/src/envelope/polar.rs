//! Stage polar: splits the linear part of a joint's transform into a rotation and a strain (METHOD §1.10).

use super::counts::STRAIN_LEN;
use super::view::Envelope;
use crate::linear::{Columns, Matrix3x4, columns, cross, dot};
use crate::numeric::sqrt;

/// Determinant below which a joint counts as hidden: a uniform scale of 0.1. A mirrored joint has a negative one.
const HIDDEN: f32 = 1.0e-3;
/// Newton steps. Seven reach single precision for a stretch between 0.25 and 4.
const STEPS: usize = 7;

/// Evaluates stage polar: [`crate::stages::polar`] with checked arguments. Writes nothing if no joint stretches.
///
/// A hidden joint has the rotation 0 and the strain 0. A joint that did not stretch in training has its linear part as
/// the rotation, without the cost of the steps.
pub(crate) fn polar(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_turns: &mut [Columns],
    out_strains: &mut [[f32; STRAIN_LEN]],
) {
    let out = out_turns.iter_mut().zip(out_strains);
    for ((map, [range]), (turn, out)) in pose.iter().zip(envelope.stretch_ranges()).zip(out) {
        (*turn, *out) = if is_hidden(map) {
            Default::default()
        } else if f32::from_le_bytes(*range) > 0.0 {
            (rotation(map), strain(map))
        } else {
            let [x, y, z, _] = columns(map);
            ([x, y, z], strain(map))
        };
    }
}

/// Whether a joint is scaled to about 0, along one axis or more, or mirrored.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn is_hidden(map: &Matrix3x4) -> bool {
    let [x, y, z, _] = columns(map);
    dot(x, cross(y, z)) < HIDDEN
}

/// Returns the strain (LᵀL - I) / 2 of a linear part L: xx, xy, xz, yy, yz, zz.
pub(crate) fn strain(map: &Matrix3x4) -> [f32; STRAIN_LEN] {
    let [x, y, z, _] = columns(map);
    let [xx, yy, zz] = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(z, z) - 1.0];
    [xx, dot(x, y), dot(x, z), yy, dot(y, z), zz].map(|entry| 0.5 * entry)
}

/// Returns the rotation nearest to a linear part L.
fn rotation(map: &Matrix3x4) -> Columns {
    let [x, y, z, _] = columns(map);
    nearest_rotation(normed([x, y, z]))
}

/// Scales a matrix to the norm of a rotation.
pub(crate) fn normed([x, y, z]: Columns) -> Columns {
    let scale = sqrt(3.0 / (dot(x, x) + dot(y, y) + dot(z, z)));
    [x, y, z].map(|column| column.map(|value| value * scale))
}

/// Returns the orthogonal matrix nearest to a matrix of the norm of a rotation. It mirrors if the matrix mirrors.
pub(crate) fn nearest_rotation([mut x, mut y, mut z]: Columns) -> Columns {
    // Newton's iteration `X <- (X + X^-T) / 2` (Higham 1986).
    for _ in 0..STEPS {
        let [a, b, c] = [cross(y, z), cross(z, x), cross(x, y)];
        let half = 0.5 / dot(x, a);
        [x, y, z] = [(x, a), (y, b), (z, c)].map(|([x, y, z], [a, b, c])| {
            [0.5 * x + half * a, 0.5 * y + half * b, 0.5 * z + half * c]
        });
    }
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::turn;

    /// Lists the quaternions whose components are -1, 0 or 1: rotations about axes in every octant, half turns too.
    fn quaternions() -> impl Iterator<Item = [f32; 4]> {
        let q = |i: u32| [i / 27, i / 9 % 3, i / 3 % 3, i % 3].map(|x| x as f32 - 1.0);
        // Miri is slow.
        let step = if cfg!(miri) { 17 } else { 1 };
        (0..81).map(q).filter(|q| *q != [0.0; 4]).step_by(step)
    }

    /// Lists symmetric matrices with the factors 1/4, 1 and 4 along three axes.
    fn stretches() -> impl Iterator<Item = [[f64; 3]; 3]> {
        let axes = [[0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0, 4.0], [-2.0, 1.0, 0.0, 3.0]];
        let factors = |i: usize| [i / 9, i / 3 % 3, i % 3].map(|at| [0.25, 1.0, 4.0][at]);
        axes.into_iter().flat_map(move |q| {
            let axes = wide(turn(q));
            (0..27).map(move |i| {
                let scaled = axes.map(|[x, y, z]| {
                    let [a, b, c] = factors(i);
                    [a * x, b * y, c * z]
                });
                product(&scaled, &transposed(&axes))
            })
        })
    }

    fn wide(rows: [[f32; 3]; 3]) -> [[f64; 3]; 3] {
        rows.map(|row| row.map(f64::from))
    }

    fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|r| [0, 1, 2].map(|c| m[c][r]))
    }

    fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        a.map(|[x, y, z]| [0, 1, 2].map(|c| x * b[0][c] + y * b[1][c] + z * b[2][c]))
    }

    /// Returns a transform with a linear part, rounded.
    fn transform(linear: &[[f64; 3]; 3]) -> Matrix3x4 {
        linear.map(|[x, y, z]| [x as f32, y as f32, z as f32, 5.0])
    }

    /// Returns the largest difference of columns from the columns of a matrix in rows.
    fn error(found: &Columns, rows: &[[f64; 3]; 3]) -> f64 {
        let expected = transposed(rows);
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        pairs.map(|(x, y)| (f64::from(*x) - y).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_stretch_does_not_change_the_rotation() {
        let mut moved = 0;
        for q in quaternions() {
            let turn = wide(turn(q));
            for stretch in stretches() {
                let map = transform(&product(&turn, &stretch));
                // Rounding of entries up to 4 turns the matrix by up to 4 times that of the least two factors, 1/4.
                let off = error(&rotation(&map), &turn);
                assert!(off < 4e-6, "{q:?} {stretch:?}: {off}");
                let [x, y, z, _] = columns(&map);
                moved += usize::from(error(&[x, y, z], &turn) > 0.1);
            }
        }
        assert!(moved > 200, "the control fails: {moved}");
    }

    #[test]
    fn a_rotation_is_its_own_rotation_without_strain() {
        for q in quaternions() {
            let turn = wide(turn(q));
            let map = transform(&turn);
            assert!(error(&rotation(&map), &turn) < 1e-6, "{q:?}");
            assert!(strain(&map).iter().all(|x| x.abs() < 1e-6), "{q:?}");
        }
    }

    #[test]
    fn the_strain_is_half_of_the_change_of_squared_lengths() {
        let map = [[2.0, 1.0, 0.0, 7.0], [0.0, 1.0, 0.0, 7.0], [0.0, 0.0, 0.5, 7.0]];
        assert_eq!(strain(&map), [1.5, 1.0, 0.0, 0.5, 0.0, -0.375]);
        for q in quaternions() {
            for stretch in stretches() {
                let square = product(&stretch, &stretch);
                let found = strain(&transform(&product(&wide(turn(q)), &stretch)));
                let places = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
                for (found, (r, c)) in found.into_iter().zip(places) {
                    let expected = 0.5 * (square[r][c] - if r == c { 1.0 } else { 0.0 });
                    // Rounding of products up to 16.
                    assert!((f64::from(found) - expected).abs() < 8e-6, "{q:?} {stretch:?}");
                }
            }
        }
    }

    #[test]
    fn a_joint_without_volume_or_mirrored_is_hidden() {
        for q in quaternions() {
            let turn = wide(turn(q));
            let hides = |x: f64, y: f64, z: f64| {
                is_hidden(&transform(&turn.map(|[a, b, c]| [a * x, b * y, c * z])))
            };
            assert!(hides(0.0, 0.0, 0.0) && hides(0.0999, 0.0999, 0.0999), "{q:?}");
            assert!(hides(0.0, 1.0, 1.0) && hides(1.0, 0.0, 1.0) && hides(1.0, 1.0, 0.0), "{q:?}");
            assert!(hides(-1.0, 1.0, 1.0) && hides(1.0, -1.0, 1.0) && hides(-1.0, -1.0, -1.0));
            assert!(!hides(1.0, 1.0, 1.0) && !hides(0.1001, 0.1001, 0.1001), "{q:?}");
            assert!(!hides(0.25, 0.25, 0.25) && !hides(-1.0, -1.0, 1.0), "{q:?}");
        }
    }
}
