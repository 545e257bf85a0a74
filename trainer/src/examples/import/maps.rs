//! The two parts of an affine map.

use nalgebra::{Matrix3, Vector3};

use crate::examples::Matrix3x4;

/// Takes a map apart: its linear part and its offset.
pub(super) fn parts(map: &Matrix3x4) -> (Matrix3<f64>, Vector3<f64>) {
    let linear = Matrix3::from_fn(|row, column| map[row][column]);
    (linear, Vector3::from_fn(|row, _| map[row][3]))
}

/// Puts a map together.
pub(super) fn joined(linear: Matrix3<f64>, offset: Vector3<f64>) -> Matrix3x4 {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| if column == 3 { offset[row] } else { linear[(row, column)] })
    })
}
