//! Rotations as inputs and as outputs of a function (METHOD §2.3).
//!
//! Quaternions are x, y, z, w, of any length but 0. Features are quadratic forms, divided by the squared length, so q
//! and -q give the same bits. The runtime computes the same features.

use crate::Error;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use sinew_runtime::kernel::EulerOrder;

/// Quaternion: x, y, z, w.
pub type Xyzw = [f64; 4];

/// Feature of a rotation: the numbers that a function takes as inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// Matrix of the rotation, row by row: 9 numbers.
    Matrix,
    /// First two rows of the matrix: 6 numbers.
    TwoRows,
    /// Direction of a rotated axis of length 1: 3 numbers.
    Swing([f64; 3]),
    /// Cosine and sine of the twist about an axis, times the squared cosine of half the swing: 2 numbers.
    Twist([f64; 3]),
    /// Angle of the twist about an axis, within half a turn, with its seam there: 1 number. For imports of other tools'
    /// rigs.
    TwistAngle([f64; 3]),
}

impl Feature {
    /// Returns the number of values of the feature.
    pub fn number_len(self) -> usize {
        match self {
            Self::Matrix => 9,
            Self::TwoRows => 6,
            Self::Swing(_) => 3,
            Self::Twist(_) => 2,
            Self::TwistAngle(_) => 1,
        }
    }

    /// Computes the feature of a rotation.
    ///
    /// # Errors
    /// If the quaternion is zero or not finite.
    pub fn of(self, rotation: Xyzw) -> Result<Vec<f64>, Error> {
        let square = square(rotation)?;
        let [x, y, z, w] = rotation;
        let about = |axis: [f64; 3]| x * axis[0] + y * axis[1] + z * axis[2];
        Ok(match self {
            Self::Matrix => matrix(rotation, square).transpose().as_slice().to_vec(),
            Self::TwoRows => matrix(rotation, square).transpose().as_slice()[..6].to_vec(),
            Self::Swing(axis) => {
                (matrix(rotation, square) * Vector3::from(axis)).as_slice().to_vec()
            }
            Self::Twist(axis) => {
                let about = about(axis);
                vec![(w * w - about * about) / square, 2.0 * w * about / square]
            }
            Self::TwistAngle(axis) => {
                let about = about(axis);
                let (about, w) =
                    if w < 0.0 || w == 0.0 && about < 0.0 { (-about, -w) } else { (about, w) };
                vec![2.0 * about.atan2(w)]
            }
        })
    }
}

/// Returns the rotation by angles in degrees about x, y and z, in an order.
///
/// The axes stay fixed, and the first axis of the order turns first, as in the rotate orders of Maya and Blender.
pub fn from_euler(order: EulerOrder, degrees: [f64; 3]) -> Xyzw {
    let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    let turn =
        |axis: usize| UnitQuaternion::from_axis_angle(&axes[axis], degrees[axis].to_radians());
    let [first, second, third] = match order {
        EulerOrder::Xyz => [0, 1, 2],
        EulerOrder::Xzy => [0, 2, 1],
        EulerOrder::Yxz => [1, 0, 2],
        EulerOrder::Yzx => [1, 2, 0],
        EulerOrder::Zxy => [2, 0, 1],
        EulerOrder::Zyx => [2, 1, 0],
    };
    (turn(third) * turn(second) * turn(first)).coords.into()
}

/// Returns a rotation relative to a neutral rotation, as `4 tan(angle / 4)` times its axis. A function of rotations has
/// these values, which are close to the rotation vector.
///
/// # Errors
/// If a quaternion is zero or not finite.
pub fn to_values(neutral: Xyzw, rotation: Xyzw) -> Result<[f64; 3], Error> {
    let relative = unit(neutral)?.inverse() * unit(rotation)?;
    let relative = if relative.w < 0.0 { -relative.into_inner() } else { relative.into_inner() };
    Ok((relative.imag() * (4.0 / (1.0 + relative.w))).into())
}

/// Returns the rotation with given values, of length 1. Any values have a rotation, also beyond one turn.
///
/// # Errors
/// If the neutral quaternion is zero or not finite.
pub fn from_values(neutral: Xyzw, values: [f64; 3]) -> Result<Xyzw, Error> {
    let v = Vector3::from(values);
    let t = v.norm_squared() / 16.0;
    let turned = Quaternion::from_parts((1.0 - t) / (1.0 + t), v * (0.5 / (1.0 + t)));
    Ok((unit(neutral)?.into_inner() * turned).coords.into())
}

/// Returns the square of a quaternion's length.
fn square(rotation: Xyzw) -> Result<f64, Error> {
    let square = rotation.iter().map(|x| x * x).sum::<f64>();
    match square {
        _ if square.is_normal() => Ok(square),
        _ if square.is_finite() => Err(zero()),
        _ => Err(Error::value("the quaternion is not finite")),
    }
}

/// Returns the error of a quaternion that is 0.
pub(crate) fn zero() -> Error {
    Error::value("the quaternion is zero")
}

fn unit(rotation: Xyzw) -> Result<UnitQuaternion<f64>, Error> {
    square(rotation)?;
    Ok(UnitQuaternion::from_quaternion(Quaternion::from(rotation)))
}

/// Returns the matrix of a quaternion with a given squared length.
fn matrix([x, y, z, w]: Xyzw, square: f64) -> Matrix3<f64> {
    let s = 2.0 / square;
    Matrix3::new(
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    const NONE: Xyzw = [0.0, 0.0, 0.0, 1.0];
    const AXIS: [f64; 3] = [0.6, 0.0, 0.8];
    const ALL: [Feature; 5] = [
        Feature::Matrix,
        Feature::TwoRows,
        Feature::Swing(AXIS),
        Feature::Twist(AXIS),
        Feature::TwistAngle(AXIS),
    ];
    const ORDERS: [(EulerOrder, [usize; 3]); 6] = [
        (EulerOrder::Xyz, [0, 1, 2]),
        (EulerOrder::Xzy, [0, 2, 1]),
        (EulerOrder::Yxz, [1, 0, 2]),
        (EulerOrder::Yzx, [1, 2, 0]),
        (EulerOrder::Zxy, [2, 0, 1]),
        (EulerOrder::Zyx, [2, 1, 0]),
    ];

    /// Returns the matrix of a turn about one axis, from the definition.
    fn about(axis: usize, degrees: f64) -> Matrix3<f64> {
        let (s, c) = degrees.to_radians().sin_cos();
        let (i, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut out = Matrix3::identity();
        (out[(i, i)], out[(i, k)], out[(k, i)], out[(k, k)]) = (c, -s, s, c);
        out
    }

    #[test]
    fn angles_turn_in_their_order() {
        let degrees = [25.0, -130.0, 70.0];
        for (order, [first, second, third]) in ORDERS {
            let expected = about(third, degrees[third])
                * about(second, degrees[second])
                * about(first, degrees[first]);
            let found = Feature::Matrix.of(from_euler(order, degrees)).unwrap();
            let found = Matrix3::from_row_slice(&found);
            assert!((found - expected).norm() < 1e-14, "{order:?}");
        }
    }

    #[test]
    fn a_quaternion_and_its_opposite_are_one_rotation_of_any_length() {
        let q = [0.3, -0.8, 0.1, -0.5];
        for feature in ALL {
            let found = feature.of(q).unwrap();
            assert_eq!(found.len(), feature.number_len());
            assert_eq!(found, feature.of(q.map(|x| -x)).unwrap(), "{feature:?}");
            for (a, b) in found.iter().zip(feature.of(q.map(|x| 3e-4 * x)).unwrap()) {
                assert!((a - b).abs() < 1e-14, "{feature:?}");
            }
        }
        let half = Feature::TwistAngle([1.0, 0.0, 0.0]);
        let seam = [[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, -0.0]].map(|q| half.of(q).unwrap());
        assert_eq!(seam[0], seam[1], "on the seam");
    }

    #[test]
    fn swing_and_twist_are_parts_of_the_rotation() {
        let axis = Vector3::from(AXIS);
        let swing = Vector3::new(0.8, 0.0, -0.6) * 1.1;
        let along = UnitQuaternion::from_scaled_axis(swing);
        for twist in [-2.0f64, 0.0, 0.7, 3.0] {
            let q = along * UnitQuaternion::from_scaled_axis(axis * twist);
            let q: Xyzw = q.coords.into();
            let turned = Feature::Swing(AXIS).of(q).unwrap();
            assert!((along * axis - Vector3::from_column_slice(&turned)).norm() < 1e-14);
            let found = Feature::Twist(AXIS).of(q).unwrap();
            let share = (0.5 * swing.norm()).cos().powi(2);
            let expected = [share * twist.cos(), share * twist.sin()];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14));
            let angle = Feature::TwistAngle(AXIS).of(q).unwrap()[0];
            assert!((angle - twist).abs() < 1e-14);
        }
    }

    #[test]
    fn values_are_rotations_about_a_neutral_one() {
        let neutral = [0.1, 0.7, -0.3, 0.5];
        for angle in [0.0, 1e-9, 0.4, 2.0, 3.1] {
            let relative = UnitQuaternion::from_scaled_axis(Vector3::from(AXIS) * angle);
            let rotation: Xyzw = (unit(neutral).unwrap() * relative).coords.into();
            for sign in [1.0, -1.0] {
                let values = to_values(neutral, rotation.map(|x| 5.0 * sign * x)).unwrap();
                let expected = Vector3::from(AXIS) * (4.0 * (0.25 * angle).tan());
                assert!((Vector3::from(values) - expected).norm() < 1e-12);
                let back = from_values(neutral, values).unwrap();
                let dot: f64 = back.iter().zip(rotation).map(|(a, b)| a * b).sum();
                assert!((dot - 1.0).abs() < 1e-14);
            }
        }
        assert_eq!(from_values(NONE, [0.0; 3]).unwrap(), NONE);
    }

    #[test]
    fn no_rotation_is_an_error() {
        for (bad, expected) in [
            ([0.0; 4], "the quaternion is zero"),
            ([1e-200, 0.0, 0.0, 0.0], "the quaternion is zero"),
            ([0.0, f64::NAN, 0.0, 1.0], "the quaternion is not finite"),
            ([f64::INFINITY, 0.0, 0.0, 1.0], "the quaternion is not finite"),
        ] {
            let mut errors: Vec<Error> = ALL.map(|feature| feature.of(bad).unwrap_err()).into();
            errors.push(to_values(bad, NONE).unwrap_err());
            errors.push(to_values(NONE, bad).unwrap_err());
            errors.push(from_values(bad, [0.0; 3]).unwrap_err());
            assert!(errors.iter().all(|error| error.to_string() == expected), "{errors:?}");
            assert!(errors.iter().all(|error| error.kind() == ErrorKind::Value));
        }
    }
}
