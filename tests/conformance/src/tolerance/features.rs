//! The tolerance of stage features.

use super::gradients::rotation_error;
use super::inexact::{Inexact, Transform, product};
use super::polar::{strains, turns};
use nalgebra::{Matrix3, Vector4};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::envelope::oracle::Pose;
use sinew_trainer::numeric::{affine, so3};
use sinew_trainer::regression::arithmetic::{Arithmetic, U};

/// Bounds the features, in the order of a file.
///
/// The gap `(L_j - L_p) o + (t_j - t_p)` has a difference, a product and three sums in a row; then
/// R_pᵀ turns it: three products. `half` bounds the effect of the error of R_pᵀ R_j. A hidden joint
/// has exact zeros, and so has its child. Curves are copies.
pub fn features(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    curves: &[f64],
    arithmetic: Arithmetic,
) -> Inexact<f64> {
    let value = oracle.features(Pose { joints: &pose.value, curves });
    let turns = turns(oracle, pose, arithmetic);
    let bound = |joint: usize| {
        let parent = oracle.skeleton.parents[joint]?;
        let ((own, own_error), (above, above_error)) = (turns[joint]?, turns[parent]?);
        let back = (&above.transpose(), &above_error.transpose());
        let rotation = back.0 * own;
        let rotation_error = product(back, (&own, &own_error), 3);
        let apart = pose.value[joint] - pose.value[parent];
        let apart_error = pose.error[joint] + pose.error[parent];
        let origin = (&oracle.origin(joint).push(1.0), &Vector4::zeros());
        let gap_error = product((&apart, &apart_error), origin, 5);
        let gap_error = product(back, (&(apart * origin.0), &gap_error), 3);
        Some(affine::joined(&half(&rotation, &rotation_error, arithmetic), &gap_error))
    };
    let of_joint = |joint| bound(joint).unwrap_or_default().transpose().as_slice().to_vec();
    let mut error: Vec<f64> = (0..pose.value.len()).flat_map(of_joint).collect();
    if oracle.stretch_ranges.is_some() {
        error.extend(strains(oracle, pose).error.iter().flatten());
    }
    error.extend(curves.iter().map(|_| 0.0));
    Inexact { value, error }
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
