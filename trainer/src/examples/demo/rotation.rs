//! Rotations by libm, so that the demo has the same bits on every CPU.

use nalgebra::{Matrix3, Vector3};

/// Makes the matrix that turns about `vector` by its length in radians (Rodrigues).
pub(super) fn rotation(vector: &Vector3<f64>) -> Matrix3<f64> {
    let angle = vector.norm();
    if angle < 1e-12 {
        return Matrix3::identity() + vector.cross_matrix();
    }
    let cross = (vector / angle).cross_matrix();
    Matrix3::identity() + cross * libm::sin(angle) + cross * cross * (1.0 - libm::cos(angle))
}

/// Rises from 0 below `from` to 1 above `to` with a continuous derivative.
pub(super) fn ramp(value: f64, from: f64, to: f64) -> f64 {
    let x = ((value - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Falls from 1 at `centre` to 0 far from it, half way down at `width`.
pub(super) fn bell(value: f64, centre: f64, width: f64) -> f64 {
    let x = (value - centre) / width;
    libm::exp2(-x * x)
}
