//! The tolerance of stage correction, and of its confidence.

use super::inexact::{Inexact, Transform, product};
use sinew_trainer::envelope::model::{EnvelopeModel, Group};
use sinew_trainer::kernel::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::kernel::certainty::Between;
use sinew_trainer::kernel::map::{Value, ValueError};
use sinew_trainer::numeric::affine::linear;

/// Correction: inputs are features times a weight, rounded once; latent values and w are off as the
/// kernel map says, `K = w (outputs z)` sums r products and rounds once more, and `Q K` is a product
/// of three terms that is added to the base. Where w is 0 beyond doubt nothing is added.
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
    let mut evidence = Between::NOTHING;
    for group in oracle.groups.iter().filter(|group| group.has_centres()) {
        let (k, k_error, known) = added(group, features, arithmetic);
        evidence = evidence.and(known);
        if group.map.certainty.shares(known, arithmetic).1 == 0.0 {
            continue;
        }
        let turn = (&linear(&pose.value[group.joint]), &linear(&pose.error[group.joint]));
        for (proxy, (k, k_error)) in group.proxies.clone().zip(k.iter().zip(&k_error)) {
            let at = first + proxy;
            let inherited = error[at] + product(turn, (k, k_error), 3);
            error[at] = inherited + (value[at].abs() + inherited) * U;
        }
    }
    let (least, most) = evidence.confidence(oracle.groups.len(), arithmetic);
    let confidence = Inexact {
        value: vec![confidence],
        error: vec![(confidence - least).max(most - confidence)],
    };
    (Inexact { value, error }, confidence)
}

/// K of a group's proxies, its errors, and what the group knows.
fn added(
    group: &Group,
    features: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Vec<Transform>, Vec<Transform>, Between) {
    let input = group.input(&features.value);
    let inherited = group.input(&features.error);
    let input_error: Vec<_> = input
        .iter()
        .zip(inherited)
        .map(|(x, error)| error.abs() + (x.abs() + error.abs()) * U)
        .collect();
    let Value { outputs, evidence } = group.map.evaluate(&input);
    let ValueError { outputs: error, evidence: between } =
        group.map.error_from(&input, &input_error, arithmetic);
    let certainty = &group.map.certainty;
    let (w, (least, most)) = (certainty.share(evidence), certainty.shares(between, arithmetic));
    let w_error = (w - least).max(most - w);
    // Errors grow by magnitudes.
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
    (y.iter().map(|y| y * w).collect(), k_error, between)
}
