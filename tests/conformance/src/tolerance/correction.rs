//! The tolerance of stage correction, and of its confidence, which combines the kernel maps' expected
//! errors with the ranges of joints and curves.

use super::confidence::{lesser, of_curves, of_stretch, within};
use super::inexact::{Inexact, Transform, product};
use super::polar::turn_error;
use nalgebra::{Matrix3, Vector3};
use sinew_runtime::envelope::HelperKind;
use sinew_trainer::envelope::model::{EnvelopeModel, Group};
use sinew_trainer::numeric::affine::linear;
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::regression::confidence::ExpectedErrorBounds;
use sinew_trainer::regression::map::{Value, ValueError};

/// Least determinant of a projected linear part of the norm of a rotation (FORMAT.md).
const FLAT: f64 = 0.1;

/// Bounds the corrected palettes and the confidence.
///
/// Inputs are features times a weight, rounded once. The kernel map bounds the errors of latent
/// values and of w. `K = w (outputs z)` sums r products and rounds once more. `L K`, with the linear
/// part L of the dominant joint, is a product of three terms, which is added to the base. If w is
/// certainly 0, nothing is added.
///
/// - `features`: all features of the pose.
pub fn correction(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    features: &Inexact<f64>,
    base: Inexact<Transform>,
    arithmetic: Arithmetic,
) -> (Inexact<Transform>, Inexact<f64>) {
    let first = oracle.first_proxy();
    let (value, confidence) = oracle.correct(&pose.value, &features.value, base.value.clone());
    let mut error = base.error;
    let mut expected = ExpectedErrorBounds::default();
    for group in oracle.groups.iter().filter(|group| group.has_centres()) {
        let (k, k_error, known) = added(oracle, group, features, arithmetic);
        expected = expected.plus(known);
        if known.map_weights(arithmetic).1 == 0.0 {
            continue;
        }
        let dominant = |of: &[Transform], none| of.get(group.joint).map_or(none, linear);
        let turn =
            (&dominant(&pose.value, Matrix3::identity()), &dominant(&pose.error, Matrix3::zeros()));
        for (proxy, (k, k_error)) in group.proxies.clone().zip(k.iter().zip(&k_error)) {
            let at = first + proxy;
            let inherited = error[at] + product(turn, (k, k_error), 3);
            error[at] = inherited + (value[at].abs() + inherited) * U;
        }
    }
    if oracle.helper_kind != HelperKind::Affine {
        let (unprojected, _) = affine(oracle).correct(&pose.value, &features.value, base.value);
        for (proxy, place) in oracle.places.iter().enumerate() {
            let at = first + proxy;
            let own = (&unprojected[at], &error[at]);
            error[at] = projected(oracle.helper_kind, own, &value[at], &place.centre, arithmetic);
        }
    }
    let (least, most) = expected.confidence(oracle.groups.len(), arithmetic);
    let of_ranges = of_ranges(oracle, pose, features, arithmetic).into_iter();
    let [least, most] = of_ranges.fold([least, most], lesser);
    let confidence = Inexact {
        value: vec![confidence],
        error: vec![(confidence - least).max(most - confidence)],
    };
    (Inexact { value, error }, confidence)
}

/// Returns the envelope without the projection of its helpers.
fn affine(oracle: &EnvelopeModel) -> EnvelopeModel {
    EnvelopeModel { helper_kind: HelperKind::Affine, ..oracle.clone() }
}

/// Bounds the projection of a transform with an error.
///
/// The rotation R has the bound of stage polar. A scale sums three products of R and L. A column of the result is a
/// product of R and the scale. The translation adds three products of the centre and of the difference of the linear
/// parts, each a subtraction. A transform that may or may not be projected is off by the projection, too.
fn projected(
    kind: HelperKind,
    (map, error): (&Transform, &Transform),
    out: &Transform,
    centre: &Vector3<f64>,
    arithmetic: Arithmetic,
) -> Transform {
    let (own, off) = (linear(map), linear(error));
    let size = own.norm();
    let unit = own * (3f64.sqrt() / size);
    let volume = unit.determinant().abs();
    // A relative change of the linear part changes the volume by at most 9 times as much, of a volume of at most 1.
    let unsure = 9.0 * (off.norm() / size + 16.0 * U);
    let [least, most] =
        [1e-3, 1e3].map(|limit| (size - limit).abs() <= off.norm() + 16.0 * U * size);
    let may_differ = (volume - FLAT).abs() <= unsure || least || most;
    if out == map && !may_differ {
        return *error;
    }
    let turn = match out == map {
        true => return error + out.abs() * 4.0,
        false => linear(out),
    };
    let scales = Vector3::from_fn(|axis, _| turn.column(axis).norm());
    let turn = Matrix3::from_columns(&[0, 1, 2].map(|axis| turn.column(axis) / scales[axis]));
    let mirror = own.determinant().signum();
    let turn_off = turn_error((&(own * mirror), &off), &(turn * mirror), arithmetic);
    let mut bound = Transform::zeros();
    for axis in 0..3 {
        let (column, column_off) = (own.column(axis).norm(), off.column(axis).norm());
        let scale_off = match kind {
            HelperKind::Rigid => 0.0,
            _ => {
                let inherited = turn_off * (column + column_off) + column_off;
                inherited + (column + inherited) * gamma(3)
            }
        };
        let own_off = turn_off * (scales[axis] + scale_off) + scale_off;
        bound.column_mut(axis).fill(own_off + (scales[axis] + own_off) * U);
    }
    for row in 0..3 {
        let apart = |axis: usize| {
            let off = bound[(row, axis)] + error[(row, axis)];
            let size = (map[(row, axis)] - out[(row, axis)]).abs() + off;
            (off + size * U, size)
        };
        let moved: f64 = (0..3).map(|axis| apart(axis).0 * centre[axis].abs()).sum();
        let size: f64 = (0..3).map(|axis| apart(axis).1 * centre[axis].abs()).sum();
        let inherited = error[(row, 3)] + moved + size * gamma(3);
        bound[(row, 3)] = inherited + (out[(row, 3)].abs() + inherited) * U;
    }
    match may_differ {
        true => bound + (map - out).abs(),
        false => bound,
    }
}

/// Bounds the confidences that the ranges of joints and curves allow: lower and upper; none for an
/// envelope without groups.
///
/// The trace of a joint's rotation sums three entries with two roundings, and its square root rounds
/// as well.
fn of_ranges(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    features: &Inexact<f64>,
    arithmetic: Arithmetic,
) -> Vec<[f64; 2]> {
    if oracle.groups.is_empty() {
        return Vec::new();
    }
    let all = features.value.chunks(12).zip(features.error.chunks(12)).zip(&oracle.pose_ranges);
    let mut out: Vec<_> = all
        .map(|((feature, error), range)| {
            let sum = |of: &[f64]| of[0].abs() + of[5].abs() + of[10].abs();
            let trace = feature[0] + feature[5] + feature[10];
            let off = sum(error) + gamma(2) * (sum(feature) + sum(error));
            let angle = |sign: f64| {
                let root = 2.0 * (sign * off - trace).max(0.0).sqrt();
                root + sign * gamma(arithmetic.root) * root
            };
            within([angle(-1.0), angle(1.0)], [1.5, *range], arithmetic)
        })
        .collect();
    let curves = &features.value[features.value.len() - oracle.curves.len()..];
    out.extend(of_stretch(oracle, pose, arithmetic));
    out.extend(of_curves(oracle, curves, arithmetic));
    out
}

/// Returns K of a group's proxies, its errors, and bounds of the group's expected error.
fn added(
    oracle: &EnvelopeModel,
    group: &Group,
    features: &Inexact<f64>,
    arithmetic: Arithmetic,
) -> (Vec<Transform>, Vec<Transform>, ExpectedErrorBounds) {
    let order = oracle.feature_order();
    let input = group.input(&features.value, order);
    let inherited = group.input(&features.error, order);
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
