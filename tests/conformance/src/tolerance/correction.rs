//! Tolerances of what the kernel maps take part in, and of the confidence.

use super::reconstruction::{Inexact, Transform, product, seen_from};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::envelope::model::{EnvelopeModel, Group};
use sinew_trainer::kernel::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::kernel::map::{STEP_ERROR, Value};
use sinew_trainer::numeric::affine::linear;

/// Joints: copies.
pub fn joints(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    Inexact { value: oracle.joints(&pose.value), error: oracle.joints(&pose.error) }
}

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
    let (mut least, mut most) = (1.0_f64, 1.0_f64);
    for group in oracle.groups.iter().filter(|group| group.has_centres()) {
        let (k, k_error, (w, w_error)) = added(group, features, arithmetic);
        least = least.min(w - w_error);
        most = most.min(w + w_error);
        if w + w_error == 0.0 {
            continue;
        }
        let turn = (&linear(&pose.value[group.joint]), &linear(&pose.error[group.joint]));
        for (proxy, (k, k_error)) in group.proxies.clone().zip(k.iter().zip(&k_error)) {
            let at = first + proxy;
            let inherited = error[at] + product(turn, (k, k_error), 3);
            error[at] = inherited + (value[at].abs() + inherited) * U;
        }
    }
    let confidence = Inexact {
        value: vec![confidence],
        error: vec![(confidence - least).max(most - confidence)],
    };
    (Inexact { value, error }, confidence)
}

/// K of a group's proxies, its errors, and w with its error.
fn added(
    group: &Group,
    features: &Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Vec<Transform>, Vec<Transform>, (f64, f64)) {
    let input = group.input(&features.value);
    let inherited = group.input(&features.error);
    let input_error: Vec<_> = input
        .iter()
        .zip(inherited)
        .map(|(x, error)| error.abs() + (x.abs() + error.abs()) * U)
        .collect();
    let Value { outputs, confidence: w } = group.map.evaluate(&input);
    let (error, w_error) = group.map.error_from(&input, &input_error, arithmetic);
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
    (y.iter().map(|y| y * w).collect(), k_error, (w, w_error))
}

/// Confidence of a rotational model: `|θ|` is behind half of three roundings and the root's, the
/// excess, its scale and their quotient behind one, two and a division's; a step's relative error is
/// known, and the difference from 1 rounds once.
pub fn confidence(
    oracle: &EnvelopeModel,
    rotations: &Inexact<Vector3<f64>, f64>,
    arithmetic: Arithmetic,
) -> Inexact<f64> {
    let (of_length, of_excess) = (gamma(2 + arithmetic.root), gamma(3 + arithmetic.division));
    let value = oracle.confidence(&rotations.value);
    // Of rotations that are longer or shorter by as much as they may be.
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
