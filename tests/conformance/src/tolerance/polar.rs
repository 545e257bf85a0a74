//! The tolerance of stage polar: rotations and strains of joints that stretch.

use super::directions::cofactor_error;
use super::inexact::{Inexact, Transform, product};
use nalgebra::{Matrix3, Vector6};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::numeric::affine::{cofactors, linear};
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};

/// Number of Newton steps.
const STEPS: usize = 7;
/// Determinant below which a joint is hidden (FORMAT.md).
const HIDDEN: f64 = 1e-3;

/// Bounds rotations and strains; a hidden joint has exact zeros.
pub fn polar(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Inexact<Matrix3<f64>>, Inexact<Vector6<f64>>) {
    let turns = turns(oracle, pose, arithmetic).into_iter().map(Option::unwrap_or_default);
    let (value, error) = turns.unzip();
    (Inexact { value, error }, strains(oracle, pose))
}

/// Returns the rotation of each joint with its bound; `None` for a hidden joint. The linear part of a
/// joint that does not stretch is its rotation.
pub(super) fn turns(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Vec<Option<(Matrix3<f64>, Matrix3<f64>)>> {
    let ranges = oracle.stretch_ranges.as_deref();
    let stretches = |joint: usize| ranges.is_some_and(|ranges| ranges[joint] > 0.0);
    let bound = |(joint, turn): (usize, Option<Matrix3<f64>>)| {
        let (map, error) = (linear(&pose.value[joint]), linear(&pose.error[joint]));
        assert_certain(&map, &error);
        let turn = turn?;
        Some(match stretches(joint) {
            true => (turn, Matrix3::repeat(turn_error((&map, &error), &turn, arithmetic))),
            false => (turn, error),
        })
    };
    oracle.turns(&pose.value).into_iter().enumerate().map(bound).collect()
}

/// Bounds the strains `(LᵀL - I) / 2`. Each entry sums three products, and 1 is subtracted on the
/// diagonal; the half is exact.
pub(super) fn strains(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Vector6<f64>> {
    let turns = oracle.turns(&pose.value);
    let bound = |(joint, (map, error)): (usize, (&Transform, &Transform))| {
        if turns[joint].is_none() {
            return Vector6::zeros();
        }
        let (map, error) = (linear(map), linear(error));
        let (back, back_error) = (map.transpose(), error.transpose());
        let mut out = product((&back, &back_error), (&map, &error), 3);
        let square = back * map;
        for at in 0..3 {
            out[(at, at)] += ((square[(at, at)] - 1.0).abs() + out[(at, at)]) * U;
        }
        Vector6::from([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| out[at] / 2.0))
    };
    let error = pose.value.iter().zip(&pose.error).enumerate().map(bound).collect();
    Inexact { value: oracle.strains(&pose.value).into_iter().map(Vector6::from).collect(), error }
}

/// Bounds the inverse's transpose of a linear part whose determinant is not about 0.
///
/// Each cofactor is bounded by itself. The determinant sums the products of the first column and its
/// cofactors, a quotient follows, then a product.
pub(super) fn inverse_error(
    map: &Matrix3<f64>,
    error: &Matrix3<f64>,
    Arithmetic { division, .. }: Arithmetic,
) -> Matrix3<f64> {
    let (cofactors, off) = (cofactors(map), cofactor_error(map, error));
    let volume = map.determinant().abs();
    let volume_error = determinant_error((map, error), (&cofactors, &off));
    assert!(volume_error < volume, "the root may have no inverse");
    let scale = 1.0 / volume;
    let scale_error = volume_error / (volume * (volume - volume_error));
    let scale_error = scale_error + (scale + scale_error) * gamma(division);
    let most = cofactors.abs() + off;
    off * scale + most * scale_error + most * ((scale + scale_error) * U)
}

/// Bounds the Frobenius norm of the error of a computed rotation.
///
/// Newton's step N keeps the rotation of a matrix, `X = R S`. A change of X by E moves R by at most
/// 2‖E‖/(σ₂ + σ₃) (Kenney and Laub 1991), with the two least singular values of X. So the errors of
/// all steps add up, each with the singular values of its result; a tenth covers the second order.
///
/// Scaling by a number s keeps the rotation, so does adding a multiple of X⁻ᵀ. Hence neither the
/// first scale's error counts nor the determinant's: only the rounding of the scaled entries, of the
/// cofactors, of their product with the scale, and of the sum. In the last step everything counts,
/// because nothing corrects the length of the result. Last, seven steps may leave some of a large
/// stretch.
pub(super) fn turn_error(
    (map, error): (&Matrix3<f64>, &Matrix3<f64>),
    turn: &Matrix3<f64>,
    Arithmetic { division, .. }: Arithmetic,
) -> f64 {
    let moved = |of: &Matrix3<f64>, error: &Matrix3<f64>| {
        let lengths = of.singular_values();
        2.0 * error.norm() / (lengths.sum() - lengths.max())
    };
    let none = Matrix3::zeros();
    let mut x = map * (3f64.sqrt() / map.norm());
    let (mut sum, mut last) = (moved(map, error) + moved(&x, &(x.abs() * U)), 0.0);
    for _ in 0..STEPS {
        let (cofactors, off) = (cofactors(&x), cofactor_error(&x, &none));
        let half = 0.5 / x.determinant();
        let next = x * 0.5 + cofactors * half;
        let rounding = off * half + cofactors.abs() * (half * U) + next.abs() * U;
        sum += moved(&next, &rounding);
        let of_volume = determinant_error((&x, &none), (&cofactors, &off)) * 2.0 * half;
        let of_scale = cofactors.abs() * (half * (of_volume + gamma(division)));
        last = (rounding + of_scale).norm();
        x = next;
    }
    1.1 * (sum + last) + (x - turn).norm()
}

/// Bounds a determinant, the sum of three products of the first column and its cofactors.
fn determinant_error(
    (map, error): (&Matrix3<f64>, &Matrix3<f64>),
    (cofactors, off): (&Matrix3<f64>, &Matrix3<f64>),
) -> f64 {
    let column = |m: &Matrix3<f64>| m.column(0).transpose();
    let (first, first_error) = (column(map), column(error));
    let (own, own_error) = (cofactors.column(0).into_owned(), off.column(0).into_owned());
    product((&first, &first_error), (&own, &own_error), 3)[(0, 0)]
}

/// Asserts that rounding cannot decide whether a joint is hidden.
fn assert_certain(map: &Matrix3<f64>, error: &Matrix3<f64>) {
    let off = cofactor_error(map, error);
    let error = determinant_error((map, error), (&cofactors(map), &off)) + U * HIDDEN;
    let volume = map.determinant();
    assert!((volume - HIDDEN).abs() > error, "a joint may be hidden or not: {volume}");
}
