//! The tolerance of stage confidence, for a rotational model, and of the confidence that the trained
//! ranges allow in any model.

use super::inexact::{Inexact, Transform};
use super::polar::strains;
use nalgebra::Vector3;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::numeric::affine::strain_norm;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::regression::confidence::{STEP_ERROR, step};

/// Bounds the confidence of a rotational model.
///
/// `|θ|` has half the error of three roundings, and the root's.
pub fn confidence(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    rotations: &Inexact<Vector3<f64>, f64>,
    arithmetic: Arithmetic,
) -> Inexact<f64> {
    let of_length = gamma(2 + arithmetic.root);
    let angles = rotations.value.iter().zip(&rotations.error).zip(&oracle.pose_ranges);
    let angles = angles.map(|((theta, error), range)| {
        let own = error + of_length * (theta.norm() + error);
        within([theta.norm() - own, theta.norm() + own], [1.0, *range], arithmetic)
    });
    let [least, most] = angles.chain(of_stretch(oracle, pose, arithmetic)).fold([1.0; 2], lesser);
    let value = oracle.confidence(&pose.value, &rotations.value);
    Inexact { value: vec![value], error: vec![(value - least).max(most - value)] }
}

/// Bounds the confidence that each joint's strain allows: lower and upper. A hidden joint has 0.
///
/// The norm sums squares with four roundings, and takes a root.
pub(super) fn of_stretch(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> Vec<[f64; 2]> {
    let (turns, strains) = (oracle.turns(&pose.value), strains(oracle, pose));
    let bound = |joint: usize| match (turns[joint], &oracle.stretch_ranges) {
        (None, _) => [0.0; 2],
        (Some(_), None) => [1.0; 2],
        (Some(_), Some(ranges)) => {
            let norm = strain_norm(&strains.value[joint].into());
            let error = strain_norm(&strains.error[joint].into());
            let own = error + gamma(2 + arithmetic.root) * (norm + error);
            within([norm - own, norm + own], [1.5, ranges[joint]], arithmetic)
        }
    };
    (0..turns.len()).map(bound).collect()
}

/// Bounds the confidence that each curve allows: lower and upper.
///
/// Half of the range rounds once, the middle and the distance from it once each.
pub(super) fn of_curves(
    oracle: &EnvelopeModel,
    curves: &[f64],
    arithmetic: Arithmetic,
) -> Vec<[f64; 2]> {
    let bound = |(value, [least, most]): (&f64, [f64; 2])| {
        let half = (most - least) / 2.0;
        let (middle, apart) = (least + half, (value - least - half).abs());
        // The range is a multiple of the rounded half, 1.5 times and more.
        let own = (3.0 * half + middle.abs() + apart) * gamma(1);
        within([apart - own, apart + own], [1.5, half], arithmetic)
    };
    curves.iter().zip(oracle.curves.iter().map(|curve| curve.range)).map(bound).collect()
}

/// Bounds the confidence of a measure between two numbers: lower and upper. The confidence is 1 up
/// to `factor` times the range, and 0 from half of the range and 0.1 beyond.
///
/// The end of the range has one rounding and the excess over it another. The scale of the excess has
/// two, and the quotient those of a division; here one more. The relative error of a step is
/// [`STEP_ERROR`], and the difference from 1 rounds once.
pub(super) fn within(
    [low, high]: [f64; 2],
    [factor, range]: [f64; 2],
    arithmetic: Arithmetic,
) -> [f64; 2] {
    let most = factor * range;
    let at = |measure: f64, sign: f64| {
        let own = U * most;
        let excess = measure - most + sign * own;
        let excess = excess + sign * gamma(5 + arithmetic.division) * excess.abs();
        let known = 1.0 - step(excess / (range / 2.0 + 0.1));
        let rounding = if known < 1.0 { STEP_ERROR * (1.0 - known) + U } else { 0.0 };
        (known - sign * rounding).clamp(0.0, 1.0)
    };
    [at(high, 1.0), at(low, -1.0)]
}

/// Returns the least of two lower bounds, and of two upper bounds.
pub(super) fn lesser(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].min(b[1])]
}
