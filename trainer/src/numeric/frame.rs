//! A tangent frame of a normal.

use nalgebra::Vector3;

/// Returns t of the right-handed frame t, b = n x t, n of a unit normal, without a branch (T. Duff et al.,
/// *Building an orthonormal basis, revisited*, JCGT 6, 2017).
pub fn tangent(n: &Vector3<f64>) -> Vector3<f64> {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    Vector3::new(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_tangent_is_of_length_1_and_square_to_its_normal() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let any = |_| Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize();
        let poles = [Vector3::z(), -Vector3::z(), Vector3::x(), -Vector3::y()];
        for n in poles.into_iter().chain((0..1000).map(any)) {
            let t = tangent(&n);
            assert!((t.norm() - 1.0).abs() < 1e-12 && t.dot(&n).abs() < 1e-12, "{n} {t}");
        }
        // The frame jumps at the equator alone: the sign of 0 counts.
        assert_eq!(tangent(&Vector3::x()), -Vector3::z());
        assert_eq!(tangent(&Vector3::new(1.0, 0.0, -0.0)), Vector3::z());
    }
}
