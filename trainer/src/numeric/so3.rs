//! Rotations: nearest rotation, logarithm and exponential (METHOD §1.3, §1.4).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Returns the axis-angle vector of a rotation matrix, angle in [0, π].
///
/// Computed as 2 atan2(|v|, w) of the quaternion, which is accurate near the identity and near π.
pub fn log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let (w, v) = quaternion(rotation);
    let sine = v.norm();
    if sine < 1e-300 { Vector3::zeros() } else { v * (2.0 * sine.atan2(w) / sine) }
}

/// Returns S - I for the half rotation S with S² = R: the displacement of a vector turned half as far; 0 for the
/// identity.
///
/// From about 150° on, the odd part fades to 0 at half a turn, where S would jump. So the result is continuous in R
/// everywhere (METHOD §1.9).
pub fn half(rotation: &Matrix3<f64>) -> Matrix3<f64> {
    let (w, v) = quaternion(rotation);
    let cross = v.cross_matrix();
    cross * (1.0 - (1.0 - w).powi(8)) + cross * cross / (1.0 + w)
}

/// Returns the quaternion of a rotation as w ≥ 0 and (x, y, z).
fn quaternion(rotation: &Matrix3<f64>) -> (f64, Vector3<f64>) {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) }
}

/// Returns the rotation matrix of an axis-angle vector.
pub fn exp(angles: &Vector3<f64>) -> Matrix3<f64> {
    Rotation3::from_scaled_axis(*angles).into_inner()
}

/// Splits `d = R S` into a proper rotation R and a symmetric S, by the SVD with the sign on the smallest singular
/// value.
///
/// Returns `None` if `d` has rank one or less, because R is then undetermined.
pub fn polar(d: &Matrix3<f64>) -> Option<(Matrix3<f64>, Matrix3<f64>)> {
    let svd = d.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let s = svd.singular_values;
    if s[1] <= 1e-12 * s[0].max(f64::MIN_POSITIVE) {
        return None;
    }
    let sign = (u * vt).determinant().signum();
    let diagonal = |third: f64| Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, third));
    let rotation = u * diagonal(sign) * vt;
    let stretch = vt.transpose() * Matrix3::from_diagonal(&s) * diagonal(sign) * vt;
    Some((rotation, stretch))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_inverts_exp_to_rounding_near_zero_and_near_pi() {
        for angle in [0.0, 1e-9, 1e-4, 0.5, 2.0, 3.1, std::f64::consts::PI - 1e-7] {
            let v = Vector3::new(0.6, -0.48, 0.64) * angle;
            assert!((log(&exp(&v)) - v).norm() < 1e-9 * angle.max(1e-6), "angle {angle}");
        }
    }

    #[test]
    fn half_of_a_rotation_twice_is_the_rotation() {
        let axis = Vector3::new(0.6, -0.48, 0.64);
        assert_eq!(half(&Matrix3::identity()), Matrix3::zeros());
        for (angle, within) in [(1e-6, 1e-15), (0.5, 1e-4), (1.6, 2e-4), (2.0, 4e-3), (2.6, 0.12)] {
            let root = half(&exp(&(axis * angle))) + Matrix3::identity();
            let off = (root * root - exp(&(axis * angle))).amax();
            assert!(off < within, "{off} at angle {angle}");
        }
    }

    #[test]
    fn half_does_not_jump_at_half_a_turn() {
        let axis = Vector3::new(0.6, -0.48, 0.64);
        let at = |angle: f64| half(&exp(&(axis * angle)));
        let pi = std::f64::consts::PI;
        for step in [1e-2, 1e-4, 1e-6] {
            assert!((at(pi - step) - at(pi + step)).amax() < 10.0 * step, "{step}");
        }
    }

    #[test]
    fn polar_recovers_a_rotation_and_a_mirroring_stretch() {
        let r = exp(&Vector3::new(0.3, 1.2, -0.7));
        for s in [
            Matrix3::new(1.2, 0.1, 0.0, 0.1, 0.9, -0.2, 0.0, -0.2, 1.5),
            Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, -0.5)),
        ] {
            let (rotation, stretch) = polar(&(r * s)).unwrap();
            assert!((rotation - r).norm() < 1e-12 && (stretch - s).norm() < 1e-12);
        }
    }

    #[test]
    fn polar_refuses_rank_one() {
        let v = Vector3::new(1.0, 2.0, 3.0);
        assert!(polar(&(v * v.transpose())).is_none());
        assert!(polar(&Matrix3::zeros()).is_none());
    }
}
