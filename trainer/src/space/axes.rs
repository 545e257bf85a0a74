//! The axes that tools disagree about: y up or z up, to the left or to the right.

use nalgebra::{Matrix3, Vector3};
use sinew_runtime::format::Axis;

/// Lists the 24 rotations that take axes to axes, the identity first.
pub(crate) fn rotations() -> impl Iterator<Item = Matrix3<f64>> {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let signed = ORDERS.into_iter().flat_map(|order| (0..8).map(move |signs| (order, signs)));
    let matrices = signed.map(|(order, signs)| {
        Matrix3::from_fn(|row, column| match order[row] == column {
            false => 0.0,
            true if signs >> row & 1 == 1 => -1.0,
            true => 1.0,
        })
    });
    matrices.filter(|turn| turn.determinant() > 0.0)
}

/// Names the axes that a rotation takes for x, y and z, as in `(x, -z, y)`.
pub(crate) fn names(turn: &Matrix3<f64>) -> String {
    let name = |row: usize| {
        let axis = turn.row(row).transpose().iamax();
        let sign = if turn[(row, axis)] < 0.0 { "-" } else { "" };
        format!("{sign}{}", ["x", "y", "z"][axis])
    };
    format!("({}, {}, {})", name(0), name(1), name(2))
}

/// Returns the unit vector of a direction.
pub(crate) fn direction(axis: Axis) -> Vector3<f64> {
    match axis {
        Axis::X => Vector3::x(),
        Axis::MinusX => -Vector3::x(),
        Axis::Y => Vector3::y(),
        Axis::MinusY => -Vector3::y(),
        Axis::Z => Vector3::z(),
        Axis::MinusZ => -Vector3::z(),
    }
}

/// Finds the direction of a unit vector along an axis.
pub(crate) fn axis(vector: &Vector3<f64>) -> Option<Axis> {
    Axis::ALL.into_iter().find(|&axis| (direction(axis) - vector).norm() < 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_rotations_and_each_has_a_name_of_its_own() {
        let mut all: Vec<String> = rotations().map(|turn| names(&turn)).collect();
        assert_eq!(all[0], "(x, y, z)");
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 24);
    }
}
