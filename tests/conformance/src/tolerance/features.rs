//! The tolerance of stage features.

use super::gradients::rotation_error;
use super::inexact::{Inexact, Transform, product, seen_from};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::numeric::{affine, so3};
use sinew_trainer::regression::arithmetic::{Arithmetic, U};

/// Bounds the features.
///
/// `M = [Q_pᵀ Q_j | Q_pᵀ (t_j - t_p)] = [R | t]` has an error of γ₄. 1 is subtracted on the
/// diagonal of R, and `(R - I) o + t` sums three products and one term. `half` bounds the effect
/// of R's error.
pub fn features(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Inexact<Transform> {
    let value = oracle.features(&pose.value);
    let bound = |joint: usize| {
        let Some(parent) = oracle.skeleton.parents[joint] else { return Transform::zeros() };
        let at = |joint: usize| (&pose.value[joint], &pose.error[joint]);
        let apart = affine::seen_from(at(parent).0, at(joint).0);
        let error = seen_from(at(parent), at(joint));
        let (shift, shift_error) = (apart.column(3).abs(), error.column(3).into_owned());
        let (rotation, rotation_error) = (linear(&apart), linear(&error));
        let turn = rotation - Matrix3::identity();
        let diagonal = (turn.abs() + rotation_error).diagonal() * U;
        let turn_error = rotation_error + Matrix3::from_diagonal(&diagonal);
        let origin = (&oracle.origin(joint), &Vector3::zeros());
        let moved = product((&turn, &turn_error), origin, 4);
        affine::joined(
            &half(&rotation, &rotation_error, arithmetic),
            &(moved + (shift + shift_error) * U + shift_error),
        )
    };
    Inexact { error: (0..value.len()).map(bound).collect(), value }
}

/// Bounds half of a rotation: `(1 - l⁸) [a] + [a][a] / (1 + c)`, l = 1 - c, for the unit quaternion
/// c >= 0, a.
///
/// The quaternion has an error d, half of the rotation's error ([`rotation_error`]). No entry of
/// the odd part changes by more than d (1 + 8 l⁷), and no entry of the even part by more than 3 d.
///
/// The length of the computed quaternion has an error of 2u (a sum of squares) and a root. c has
/// that error and a quotient's, l one rounding more. l⁸ has eight times the relative error of l,
/// and 7u from its three squares. The factor of the odd part is a difference and a quotient by the
/// length; a product follows. The factor of the even part has two lengths, a sum, a product and a
/// quotient; its entries of the quaternion have 2u and a product. The sum of both parts rounds
/// once.
fn half(rotation: &Matrix3<f64>, error: &Matrix3<f64>, arithmetic: Arithmetic) -> Matrix3<f64> {
    let d = rotation_error(rotation, error) / 2.0;
    let angles = so3::log(rotation);
    let (sine, c) = (angles.norm() / 2.0).sin_cos();
    let axis = angles.try_normalize(0.0).unwrap_or_default().cross_matrix();
    let low = (1.0 - c + d).min(1.0);
    let steepness = 4.0 + 8.0 * (1.0 - c + d).powi(7);
    let length = (2 + arithmetic.root) as f64;
    let division = arithmetic.division as f64;
    let of_low = 8.0 * low.powi(7) * (c * (length + division) + low) + 7.0 * low.powi(8);
    let odd = axis.abs() * (sine * (of_low + 2.0 + length + division));
    let even = (axis * axis).abs() * ((1.0 - c) * (5.0 + 2.0 * length + division));
    let inherited = Matrix3::repeat(steepness * d);
    inherited + ((odd + even) + so3::half(rotation).abs() + inherited) * U
}
