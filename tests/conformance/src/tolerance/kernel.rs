//! The tolerance of stage kernel, and of its confidence.

use super::inexact::Inexact;
use sinew_runtime::kernel::{Normalise, QueryRule};
use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
use sinew_trainer::regression::rotations::{Feature, Xyzw};
use sinew_trainer::scattered::bound::{bound, distances};
use sinew_trainer::scattered::model::{Input, InputKind, KernelModel, Output, OutputKind};

/// Bounds the outputs of a kernel and the confidence.
///
/// `feature_error` bounds the features of rotations. METHOD §2.7's E bounds the values for given
/// errors of the features. The fade bounds the confidence; `w y + (1 - w) n` rounds three times.
/// Clamping to a range increases no error. A rotation has half the error of its vector and the
/// rounding of `rotation`. A share of a sum has the errors of the sum and of the number, and a
/// division's.
///
/// # Panics
/// If the CPU refuses a query.
pub fn kernel(
    oracle: &KernelModel,
    query: &[f32],
    arithmetic: Arithmetic,
) -> (Inexact<f64>, Inexact<f64>) {
    let query: Vec<f64> = query.iter().map(|x| f64::from(*x)).collect();
    let right = oracle.evaluate(&query).expect("the query can be evaluated");
    let (mut x, x_error) = features(&oracle.inputs, &query, arithmetic);
    if oracle.query == QueryRule::Clamp {
        for (x, [low, high]) in x.iter_mut().zip(&oracle.ranges) {
            *x = x.max(*low).min(*high);
        }
    }
    let w = right.confidence;
    let w_error = oracle.fade.error(&distances(&oracle.sum, &x, &x_error), arithmetic);
    let mut values = oracle.sum.evaluate(&x);
    let mut error = bound(&oracle.sum, &x, &x_error, arithmetic);
    if oracle.query == QueryRule::Fade {
        let neutral = oracle.outputs.iter().flat_map(neutral);
        for ((y, error), neutral) in values.iter_mut().zip(&mut error).zip(neutral) {
            let apart = y.abs() + neutral.abs() + *error;
            let most = (w + w_error) * (y.abs() + *error) + (1.0 - w + w_error) * neutral.abs();
            *error = w_error * apart + (w + w_error) * *error + gamma(3) * most;
            *y = w * *y + (1.0 - w) * neutral;
        }
    }
    let (mut out, mut marked) = (Vec::new(), Vec::new());
    let (mut values, mut error) = (values.as_slice(), error.as_slice());
    for Output { kind, .. } in &oracle.outputs {
        let (own, own_error);
        (own, values) = values.split_at(kind.value_len());
        (own_error, error) = error.split_at(kind.value_len());
        match (kind, own, own_error) {
            (OutputKind::Rotation { neutral }, &[x, y, z], &[a, b, c]) => {
                out.extend(rotation(*neutral, [x, y, z], [a, b, c], arithmetic));
            }
            (OutputKind::Scalar { low, high, normalised: true, .. }, &[y], _) => {
                marked.push((out.len(), y.max(*low).min(*high)));
                out.extend(own_error);
            }
            _ => out.extend(own_error),
        }
    }
    share(oracle.normalise, &marked, &mut out, arithmetic);
    let confidence = Inexact { value: vec![w], error: vec![w_error] };
    (Inexact { value: right.numbers, error: out }, confidence)
}

/// Returns the features of all inputs with their bounds; those of plain numbers are 0.
fn features(inputs: &[Input], query: &[f64], arithmetic: Arithmetic) -> (Vec<f64>, Vec<f64>) {
    let (mut value, mut error, mut left) = (Vec::new(), Vec::new(), query);
    for Input { kind, .. } in inputs {
        let own;
        (own, left) = left.split_at(kind.number_len());
        match (kind, own) {
            (InputKind::Rotation { feature, .. }, &[x, y, z, w]) => {
                let q = [x, y, z, w];
                let own = feature.of(q).expect("the rotation has a direction");
                error.extend(feature_error(*feature, q, &own, arithmetic));
                value.extend(own);
            }
            _ => {
                value.extend(own);
                error.extend(own.iter().map(|_| 0.0));
            }
        }
    }
    (value, error)
}

/// Returns the bounds of the features of a rotation.
///
/// |q|² has four roundings, a quotient by it a division's more. The products of an entry have three
/// roundings of their own; then come their sum and its difference from 1. v · axis has three
/// roundings. A product with an axis sums three. An angle has the error of its point, 2.1 ULP of an
/// arc tangent and its quotient, and at most a full turn.
fn feature_error(feature: Feature, q: Xyzw, value: &[f64], arithmetic: Arithmetic) -> Vec<f64> {
    let [x, y, z, w] = q;
    let square: f64 = q.iter().map(|x| x * x).sum();
    let entry = |r: usize, c: usize| {
        let v = [x, y, z].map(|x| x.abs());
        let sum = if r == c {
            square - w * w - v[r] * v[r]
        } else {
            v[r] * v[c] + w.abs() * v[3 - r - c]
        };
        let rounded = gamma(8 + arithmetic.division) * 2.0 * sum / square;
        rounded + if r == c { U * (1.0 + 2.0 * sum / square) } else { 0.0 }
    };
    let about = |axis: [f64; 3]| {
        let terms = [x * axis[0], y * axis[1], z * axis[2]];
        let most = terms.iter().map(|x| x.abs()).sum::<f64>();
        (terms.iter().sum::<f64>(), most, gamma(3) * most)
    };
    match feature {
        Feature::Matrix | Feature::TwoRows => {
            (0..value.len()).map(|i| entry(i / 3, i % 3)).collect()
        }
        Feature::Swing(axis) => {
            let row = |r: usize| {
                let terms = (0..3).map(|c| (2.0 * gamma(3) + entry(r, c)) * axis[c].abs());
                terms.sum::<f64>()
            };
            (0..3).map(row).collect()
        }
        Feature::Twist(axis) => {
            let (_, most, error) = about(axis);
            let quotient = gamma(6 + arithmetic.division);
            let of_square =
                (2.0 * most + error) * error + gamma(2) * (w * w + (most + error).powi(2));
            let of_product = 2.0 * w.abs() * error;
            let scaled =
                |error: f64, value: f64| error / square * (1.0 + quotient) + quotient * value.abs();
            vec![scaled(of_square, value[0]), scaled(of_product, value[1])]
        }
        Feature::TwistAngle(axis) => {
            let (about, _, error) = about(axis);
            let least = (about.abs() - error).max(0.0).powi(2) + w * w;
            let of_point = 2.0 * error * (w.abs() + error) / least;
            let rounded = gamma(6 + arithmetic.division) * std::f64::consts::PI;
            let whole = 2.0 * std::f64::consts::PI;
            vec![if of_point < whole { of_point + rounded } else { whole }]
        }
    }
}

/// Returns the neutral values of an output, which a faded query has.
fn neutral(output: &Output) -> Vec<f64> {
    match output.kind {
        OutputKind::Scalar { neutral, .. } => vec![neutral],
        OutputKind::Vector3 { neutral } => neutral.to_vec(),
        OutputKind::Rotation { .. } => vec![0.0; 3],
    }
}

/// Returns the bounds of a rotation's quaternion.
///
/// The quaternion of a vector changes by half as much as the vector. h and 1 + h have five
/// roundings; a quotient adds those and a division's. The product with the neutral rotation sums
/// four. The oracle normalises the neutral rotation.
fn rotation(neutral: Xyzw, values: [f64; 3], error: [f64; 3], arithmetic: Arithmetic) -> [f64; 4] {
    let h = values.iter().map(|y| y * y).sum::<f64>() / 16.0;
    let inherited = 0.5 * error.iter().map(|e| e * e).sum::<f64>().sqrt();
    let quotient = gamma(11 + arithmetic.division);
    let [x, y, z] = values.map(|y| 0.5 * y.abs() / (1.0 + h));
    let turn = [x, y, z, 1.0];
    let length = neutral.iter().map(|x| x * x).sum::<f64>().sqrt();
    let of = |i: usize, j: usize| {
        let own = inherited + quotient * turn[j];
        neutral[i].abs() * (own + (gamma(4) + (length - 1.0).abs()) * (turn[j] + own))
    };
    PRODUCTS.map(|row| row.iter().map(|&(i, j)| of(i, j)).sum())
}

/// Index pairs of the products in each entry of a product of quaternions.
const PRODUCTS: [[(usize, usize); 4]; 4] = [
    [(3, 0), (0, 3), (1, 2), (2, 1)],
    [(3, 1), (0, 2), (1, 3), (2, 0)],
    [(3, 2), (0, 1), (1, 0), (2, 3)],
    [(3, 3), (0, 0), (1, 1), (2, 2)],
];

/// Widens the bounds of the normalised outputs, given by index and value, if they are divided by
/// their sum, or may be.
fn share(rule: Normalise, marked: &[(usize, f64)], error: &mut [f64], arithmetic: Arithmetic) {
    let least = match rule {
        Normalise::Never => return,
        Normalise::Always => 1e-12,
        Normalise::AboveOne => 1.0,
    };
    let sum: f64 = marked.iter().map(|(_, x)| x).sum();
    let magnitude: f64 = marked.iter().map(|(_, x)| x.abs()).sum();
    let sum_error: f64 = marked.iter().map(|(at, _)| error[*at]).sum::<f64>();
    let sum_error = sum_error + gamma(marked.len()) * (magnitude + sum_error);
    if sum + sum_error <= least {
        return;
    }
    for &(at, x) in marked {
        let share = x / sum;
        let rounded = gamma(arithmetic.division) * share.abs();
        let own = (error[at] + share.abs() * sum_error) / (sum - sum_error) * (1.0 + U) + rounded;
        // Rounding may decide whether the numbers are divided.
        let undecided = if sum - sum_error <= least { (x - share).abs() + error[at] } else { 0.0 };
        error[at] = own + undecided;
    }
}
