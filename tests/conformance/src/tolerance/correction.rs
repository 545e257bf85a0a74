//! The tolerance of stage correction, and of its confidence, which combines the kernel maps'
//! expected with the joints' ranges.

use super::inexact::{Inexact, Transform, product};
use sinew_trainer::envelope::model::{EnvelopeModel, Group};
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::regression::confidence::{ExpectedErrorBounds, STEP_ERROR};
use sinew_trainer::regression::map::{Value, ValueError};

/// Bounds the corrected palettes and the confidence.
///
/// Inputs are features times a weight, rounded once. The kernel map bounds the errors of latent
/// values and of w. `K = w (outputs z)` sums r products and rounds once more. `Q K` is a product of
/// three terms, which is added to the base. If w is certainly 0, nothing is added.
pub fn correction(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    features: &Inexact<Transform>,
    base: Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Inexact<Transform>, Inexact<f64>) {
    let first = oracle.first_proxy();
    let (value, confidence) = oracle.correct(&pose.value, &features.value, base.value.clone());
    let mut error = base.error;
    let mut expected = ExpectedErrorBounds::default();
    for group in oracle.groups.iter().filter(|group| group.has_centres()) {
        let (k, k_error, known) = added(group, features, arithmetic);
        expected = expected.plus(known);
        if known.map_weights(arithmetic).1 == 0.0 {
            continue;
        }
        let turn = (&linear(&pose.value[group.joint]), &linear(&pose.error[group.joint]));
        for (proxy, (k, k_error)) in group.proxies.clone().zip(k.iter().zip(&k_error)) {
            let at = first + proxy;
            let inherited = error[at] + product(turn, (k, k_error), 3);
            error[at] = inherited + (value[at].abs() + inherited) * U;
        }
    }
    let (least, most) = expected.confidence(oracle.groups.len(), arithmetic);
    let (least_known, most_known) = joint_confidence(oracle, features, arithmetic);
    let (least, most) = (least.min(least_known), most.min(most_known));
    let confidence = Inexact {
        value: vec![confidence],
        error: vec![(confidence - least).max(most - confidence)],
    };
    (Inexact { value, error }, confidence)
}

/// Returns bounds of the confidence that the joints' angles allow: lower and upper.
///
/// The trace sums three entries with two roundings, and its square root rounds as well. The excess
/// has one rounding of its bound and one of the difference; its scale has two, and the quotient
/// those of a division. The relative error of a step is [`STEP_ERROR`], and the difference from 1
/// rounds once.
fn joint_confidence(
    oracle: &EnvelopeModel,
    features: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (f64, f64) {
    let shifted = |sign: f64| {
        let of_joint = |((feature, error), range): ((&Transform, &Transform), &f64)| {
            let entries = |m: &Transform| linear(m).diagonal().abs().sum();
            let trace = linear(feature).trace();
            let off = entries(error) + gamma(2) * (entries(feature) + entries(error));
            let root = 2.0 * (sign * off - trace).max(0.0).sqrt();
            let most = 1.5 * range;
            let own = gamma(arithmetic.root) * root + U * most;
            let excess = gamma(4 + arithmetic.division) * ((root - most).abs() + own);
            let angle = (root + sign * (own + excess)).max(0.0);
            // The confidence depends on the features' trace only.
            Transform::from_diagonal_element(-angle * angle / 12.0)
        };
        let both = features.value.iter().zip(&features.error);
        let moved: Vec<_> = both.zip(&oracle.pose_ranges).map(of_joint).collect();
        oracle.joint_confidences(&moved).into_iter().fold(1.0, f64::min)
    };
    let rounded = |known: f64, sign: f64| {
        if known < 1.0 { known + sign * (STEP_ERROR * (1.0 - known) + U) } else { 1.0 }
    };
    (rounded(shifted(1.0), -1.0).max(0.0), rounded(shifted(-1.0), 1.0).min(1.0))
}

/// Returns K of a group's proxies, its errors, and bounds of the group's expected error.
fn added(
    group: &Group,
    features: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Vec<Transform>, Vec<Transform>, ExpectedErrorBounds) {
    let input = group.input(&features.value);
    let inherited = group.input(&features.error);
    let input_error: Vec<_> = input
        .iter()
        .zip(inherited)
        .map(|(x, error)| error.abs() + (x.abs() + error.abs()) * U)
        .collect();
    let Value { outputs, expected_error } = group.map.evaluate(&input);
    let ValueError { outputs: error, expected_error: bounds } =
        group.map.error_from(&input, &input_error, arithmetic);
    let (w, (least, most)) = (expected_error.map_weight(), bounds.map_weights(arithmetic));
    let w_error = (w - least).max(most - w);
    // Errors are propagated by the magnitudes of the outputs.
    let mut magnitudes = group.clone();
    magnitudes.outputs.col_iter_mut().flat_map(|c| c.iter_mut()).for_each(|x| *x = x.abs());
    let rounding = gamma(outputs.len());
    let off = |(z, error): (&f64, &f64)| error + (z.abs() + error) * rounding;
    let latent_error: Vec<_> = outputs.iter().zip(&error).map(off).collect();
    let y: Vec<_> = group.maps(&outputs).collect();
    let y_error = magnitudes.maps(&latent_error);
    let faded = |(y, y_error): (&Transform, Transform)| {
        let error = y.abs() * w_error + y_error * (w + w_error);
        ((y * w).abs() + error) * U + error
    };
    let k_error = y.iter().zip(y_error).map(faded).collect();
    (y.iter().map(|y| y * w).collect(), k_error, bounds)
}
