//! Features of a query: quadratic forms of quaternions, divided by the squared length (METHOD
//! §2.3).

use super::rows::{InputKind, InputRow};
use crate::linear::{dot, squared_length, turn};
use crate::numeric::quadrant_angle;

/// Largest number of features of an input.
pub(super) const FEATURES_MAX: usize = 9;

/// Computes the features of an input's numbers; unused places are 0.
pub(super) fn features(input: &InputRow, numbers: [f32; 4]) -> [f32; FEATURES_MAX] {
    let [x, y, z, w] = numbers;
    let about = dot([x, y, z], input.axis);
    let mut out = [0.0; FEATURES_MAX];
    match input.kind {
        InputKind::Scalar => copy_to(&mut out, &[x]),
        InputKind::Vector3 => copy_to(&mut out, &[x, y, z]),
        InputKind::Rotation | InputKind::TwoRows => {
            let rows = turn(numbers);
            copy_to(
                &mut out,
                rows.as_flattened().get(..input.kind.feature_len()).unwrap_or_default(),
            );
        }
        InputKind::Swing => copy_to(&mut out, &turn(numbers).map(|row| dot(row, input.axis))),
        InputKind::Twist => {
            let square = squared_length(numbers);
            copy_to(&mut out, &[(w * w - about * about) / square, 2.0 * w * about / square]);
        }
        InputKind::TwistAngle => copy_to(&mut out, &[twist_angle(about, w)]),
    }
    out
}

/// Computes the derivatives of the features with respect to the numbers, one row per feature;
/// unused places are 0.
pub(super) fn gradients(input: &InputRow, numbers: [f32; 4]) -> [[f32; 4]; FEATURES_MAX] {
    let axis = input.axis;
    let [x, y, z, w] = numbers;
    let about = dot([x, y, z], axis);
    let mut out = [[0.0; 4]; FEATURES_MAX];
    match input.kind {
        InputKind::Scalar | InputKind::Vector3 => copy_to(&mut out, &UNITS),
        InputKind::Rotation | InputKind::TwoRows => {
            let rows = turn_gradients(numbers);
            copy_to(
                &mut out,
                rows.as_flattened().get(..input.kind.feature_len()).unwrap_or_default(),
            );
        }
        InputKind::Swing => copy_to(&mut out, &turn_gradients(numbers).map(|row| sum(row, axis))),
        InputKind::Twist => {
            let s = 2.0 / squared_length(numbers);
            let [cosine, sine, ..] = features(input, numbers);
            let scaled = numbers.map(|x| x * s);
            let along = |by_axis: f32, by_w: f32| {
                let [a, b, c] = axis;
                [by_axis * a, by_axis * b, by_axis * c, by_w]
            };
            let (about, w) = (about * s, w * s);
            let rows = [
                subtract_scaled(along(-about, w), cosine, scaled),
                subtract_scaled(along(w, about), sine, scaled),
            ];
            copy_to(&mut out, &rows);
        }
        InputKind::TwistAngle => {
            let square = about * about + w * w;
            // After a half turn about another axis the twist angle is undefined.
            let s = if square.is_normal() { 2.0 / square } else { 0.0 };
            let [a, b, c] = axis.map(|x| x * (w * s));
            copy_to(&mut out, &[[a, b, c, -about * s]]);
        }
    }
    out
}

const UNITS: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Copies values to the start.
fn copy_to<T: Copy>(out: &mut [T], values: &[T]) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out = *value);
}

/// Returns the twist angle in radians, within half a turn. A quaternion and its negative give equal
/// angles.
fn twist_angle(about: f32, w: f32) -> f32 {
    let is_flipped = w < 0.0 || w == 0.0 && about < 0.0;
    let (about, w) = if is_flipped { (-about, -w) } else { (about, w) };
    let angle = 2.0 * quadrant_angle(if about < 0.0 { -about } else { about }, w);
    if about < 0.0 { -angle } else { angle }
}

/// Computes the derivatives of a rotation matrix with respect to the quaternion.
///
/// R = I + M / |q|² with a quadratic M. Let p = 2 q / |q|². The derivative of M over |q|² is linear
/// in p, and the derivative of |q|² over |q|² is p.
fn turn_gradients(q: [f32; 4]) -> [[[f32; 4]; 3]; 3] {
    let s = 2.0 / squared_length(q);
    let p = q.map(|x| x * s);
    let [x, y, z, w] = p;
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = turn(q);
    [
        [
            subtract_scaled([0.0, -2.0 * y, -2.0 * z, 0.0], xx - 1.0, p),
            subtract_scaled([y, x, -w, -z], xy, p),
            subtract_scaled([z, w, x, y], xz, p),
        ],
        [
            subtract_scaled([y, x, w, z], yx, p),
            subtract_scaled([-2.0 * x, 0.0, -2.0 * z, 0.0], yy - 1.0, p),
            subtract_scaled([-w, z, y, -x], yz, p),
        ],
        [
            subtract_scaled([z, -w, x, -y], zx, p),
            subtract_scaled([w, z, y, x], zy, p),
            subtract_scaled([-2.0 * x, -2.0 * y, 0.0, 0.0], zz - 1.0, p),
        ],
    ]
}

/// Returns a - f b.
fn subtract_scaled(a: [f32; 4], f: f32, b: [f32; 4]) -> [f32; 4] {
    let mut out = a;
    out.iter_mut().zip(b).for_each(|(out, b)| *out -= f * b);
    out
}

/// Returns the weighted sum of rows.
fn sum(rows: [[f32; 4]; 3], weights: [f32; 3]) -> [f32; 4] {
    let mut out = [0.0; 4];
    for (row, weight) in rows.iter().zip(weights) {
        out.iter_mut().zip(row).for_each(|(out, x)| *out += weight * x);
    }
    out
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use core::f32::consts::PI;

    const AXIS: [f32; 3] = [0.48, 0.6, 0.64];
    const QUERIES: [[f32; 4]; 6] = [
        [0.1, -0.7, 0.4, 0.5],
        [-3.0, 1.0, 2.0, -0.5],
        [0.02, 0.01, -0.03, 0.2],
        [0.0, 0.0, 0.0, 5.0],
        [0.3, 0.4, 0.2, 0.0],
        [1e-9, 3e-9, -2e-9, 4e-9],
    ];

    fn input(kind: InputKind) -> InputRow {
        InputRow { kind, euler: None, axis: if kind.has_axis() { AXIS } else { [0.0; 3] } }
    }

    fn rotations() -> impl Iterator<Item = InputKind> {
        InputKind::ALL.into_iter().filter(|kind| kind.is_rotation())
    }

    #[test]
    fn a_quaternion_and_its_opposite_have_the_same_bits() {
        let bits = |features: [f32; FEATURES_MAX]| features.map(|x| (x + 0.0).to_bits());
        for kind in rotations() {
            for q in QUERIES.into_iter().chain([[0.48, 0.6, 0.64, 0.0], [0.64, 0.0, -0.48, 0.0]]) {
                let (one, other) =
                    (features(&input(kind), q), features(&input(kind), q.map(|x| -x)));
                assert_eq!(bits(one), bits(other), "{kind:?} {q:?}");
            }
        }
    }

    #[test]
    fn a_turn_about_the_axis_is_all_twist_and_no_swing() {
        for half in [-1.4f32, -0.6, 0.0, 0.3, 1.2] {
            let (sine, cosine) = (f64::from(half).sin() as f32, f64::from(half).cos() as f32);
            let [x, y, z] = AXIS.map(|x| 3.0 * sine * x);
            let q = [x, y, z, 3.0 * cosine];
            let near =
                |found: f32, expected: f32| assert!((found - expected).abs() < 1e-6, "{half}");
            let [a, b, c, ..] = features(&input(InputKind::Swing), q);
            AXIS.iter().zip([a, b, c]).for_each(|(axis, found)| near(found, *axis));
            let [c, s, ..] = features(&input(InputKind::Twist), q);
            near(c, f64::from(2.0 * half).cos() as f32);
            near(s, f64::from(2.0 * half).sin() as f32);
            near(features(&input(InputKind::TwistAngle), q)[0], 2.0 * half);
        }
    }

    #[test]
    fn a_matrix_turns_as_its_quaternion_does() {
        // A quarter turn about z, with quaternion length 2: x goes to y.
        let q = [0.0, 0.0, core::f32::consts::SQRT_2, core::f32::consts::SQRT_2];
        let expected = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let found = features(&input(InputKind::Rotation), q);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        let two = features(&input(InputKind::TwoRows), q);
        assert_eq!(two[..6], found[..6]);
        assert_eq!(two[6..], [0.0; 3]);
    }

    #[test]
    fn half_turns_have_one_angle() {
        let angle = |q| features(&input(InputKind::TwistAngle), q)[0];
        let about = [0.48, 0.6, 0.64, 0.0];
        assert_eq!([angle(about), angle(about.map(|x| -x))], [PI; 2]);
        assert_eq!(angle([0.8, 0.0, -0.6, 0.0]), 0.0);
        assert_eq!(angle([0.8, 0.0, -0.6, -0.0]), 0.0);
    }

    #[test]
    fn gradients_are_those_of_the_features() {
        for kind in InputKind::ALL {
            for q in QUERIES.into_iter().take(3) {
                let input = input(kind);
                let found = gradients(&input, q);
                // Central differences in the features' own single precision. The step balances the
                // features' rounding and the error of the differences.
                let length = squared_length(q).sqrt();
                let step = 1e-3 * length;
                for column in 0..kind.number_len() {
                    let at = |h: f32| {
                        let mut q = q;
                        q[column] += h;
                        features(&input, q)
                    };
                    let (after, before) = (at(step), at(-step));
                    for f in 0..kind.feature_len() {
                        let expected = (after[f] - before[f]) / (2.0 * step);
                        let apart = (found[f][column] - expected).abs();
                        assert!(apart * length < 5e-4, "{kind:?} {q:?} {f} {column} {apart}");
                    }
                }
            }
        }
    }
}
