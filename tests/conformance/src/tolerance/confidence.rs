//! The tolerance of stage confidence, for a rotational model.

use super::inexact::Inexact;
use nalgebra::Vector3;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::regression::confidence::STEP_ERROR;

/// Bounds the confidence of a rotational model.
///
/// `|θ|` has half the error of three roundings, and the root's. The excess has one rounding, its
/// scale two, and their quotient those of a division. The relative error of a step is
/// [`STEP_ERROR`], and the difference from 1 rounds once.
pub fn confidence(
    oracle: &EnvelopeModel,
    rotations: &Inexact<Vector3<f64>, f64>,
    arithmetic: Arithmetic,
) -> Inexact<f64> {
    let (of_length, of_excess) = (gamma(2 + arithmetic.root), gamma(3 + arithmetic.division));
    let value = oracle.confidence(&rotations.value);
    // The confidence of rotations that are longer or shorter by their bounds.
    let shifted = |sign: f64| {
        let angles = rotations.value.iter().zip(&rotations.error).zip(&oracle.pose_ranges);
        let angles = angles.map(|((theta, error), range)| {
            let length = theta.norm();
            let own = error + of_length * (length + error);
            let excess = (length - range).abs() + own;
            Vector3::x() * (length + sign * (own + of_excess * excess)).max(0.0)
        });
        oracle.confidence(&angles.collect::<Vec<_>>())
    };
    let (least, most) = (shifted(1.0), shifted(-1.0));
    let rounding = if least < 1.0 { STEP_ERROR * (1.0 - least) + U } else { 0.0 };
    Inexact { value: vec![value], error: vec![(value - least).max(most - value) + rounding] }
}
