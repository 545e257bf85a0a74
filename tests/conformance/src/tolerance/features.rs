//! The tolerance of stage features.

use super::inexact::{Inexact, Transform, product, seen_from};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::kernel::arithmetic::U;
use sinew_trainer::numeric::affine::linear;

/// Features: `M = [Q_pᵀ Q_j | Q_pᵀ (t_j - t_p)]` is behind γ₄; 1 is taken off on the diagonal of
/// R, and `(R - I) o + t` sums three products and one term.
pub fn features(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    let value = oracle.features(&pose.value);
    let bound = |joint: usize| {
        let Some(parent) = oracle.skeleton.parents[joint] else { return Transform::zeros() };
        let at = |joint: usize| (&pose.value[joint], &pose.error[joint]);
        let (turn, origin) = (linear(&value[joint]), oracle.origin(joint));
        let mut error = seen_from(at(parent), at(joint));
        let shift = value[joint].column(3) - turn * origin;
        let shift_error = error.column(3).into_owned();
        let diagonal = (turn.abs() + linear(&error)).diagonal() * U;
        let turn_error = linear(&error) + Matrix3::from_diagonal(&diagonal);
        let turned = product((&turn, &turn_error), (&origin, &Vector3::zeros()), 4);
        error.fixed_columns_mut::<3>(0).copy_from(&turn_error);
        error.set_column(3, &(turned + (shift.abs() + shift_error) * U + shift_error));
        error
    };
    Inexact { error: (0..value.len()).map(bound).collect(), value }
}
