//! Values with bounds of their errors, and the bounds that all stages use.

use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, SMatrix};
use sinew_trainer::regression::arithmetic::{U, gamma};

/// Allowance for products that underflow. Each loses less than 2⁻¹²⁶ even if subnormal numbers are
/// flushed, and no coefficient that multiplies the loss exceeds 1e7.
pub const UNDERFLOW: f64 = 1e-30;
/// Rounding of f64 over some thousand operations on numbers near 1: for properties that are exact
/// in real arithmetic and are evaluated in f64 (METHOD §1.7).
pub const EXACT: f64 = 1e-12;
/// As [`EXACT`], after solving a system of a condition near 1e4 by another method (METHOD §1.7.3).
pub const SOLVED: f64 = 1e-10;
/// As [`EXACT`], through the pseudo-inverse of a system of a condition near 1e5.
pub const PSEUDO_SOLVED: f64 = 1e-9;
/// Largest ratio of the bounds' diagonal to that of the skin's own box at rest. The proxies' boxes
/// are then the skin's own, widened by the runtime's slack of 1e-5 and 2(K + 8)u of sums of up to
/// four extents.
pub const BOUNDS_AT_REST: f64 = 1.001;
/// Largest ratio of the diagonals in trained poses. Each proxy's box moves as a whole: a rotation
/// makes the box up to √3 longer. A transform may also stretch where no vertex of its box follows
/// it alone. This value is not derived: it guards against bounds that hold only because they are
/// enormous.
pub const BOUNDS_POSED: f64 = 6.0;

/// A transform from rest to posed.
pub type Transform = Matrix3x4<f64>;

/// Values, each with the bound of the error of an f32 evaluation, entry by entry.
#[derive(Clone, Debug)]
pub struct Inexact<V, E = V> {
    /// The oracle's values.
    pub value: Vec<V>,
    /// Bounds of the error.
    pub error: Vec<E>,
}

impl<const R: usize, const C: usize> Inexact<SMatrix<f64, R, C>> {
    /// Wraps values that the backend receives exactly.
    pub fn exact(value: Vec<SMatrix<f64, R, C>>) -> Self {
        Self { error: vec![SMatrix::zeros(); value.len()], value }
    }

    /// Wraps values that the backend receives rounded to f32.
    pub fn rounded(value: Vec<SMatrix<f64, R, C>>) -> Self {
        Self { error: value.iter().map(|m| m.abs() * U).collect(), value }
    }
}

/// Bounds `[A⁻¹ L | A⁻¹ (t - t_a)]` of a transform `b = [L | t]`.
///
/// - `inverse`: the inverse of the linear part of `a`.
pub(super) fn seen_from(
    inverse: (&Matrix3<f64>, &Matrix3<f64>),
    (a, a_error): (&Transform, &Transform),
    (b, b_error): (&Transform, &Transform),
) -> Transform {
    let (mut apart, mut apart_error) = (*b, *b_error);
    apart.column_mut(3).axpy(-1.0, &a.column(3), 1.0);
    apart_error.column_mut(3).axpy(1.0, &a_error.column(3), 1.0);
    product(inverse, (&apart, &apart_error), 4)
}

/// Bounds a product after n roundings: `E_a |b| + |a| E_b + E_a E_b + γₙ (|a| + E_a)(|b| + E_b)`.
pub(super) fn product<const R: usize, const K: usize, const C: usize>(
    (a, a_error): (&SMatrix<f64, R, K>, &SMatrix<f64, R, K>),
    (b, b_error): (&SMatrix<f64, K, C>, &SMatrix<f64, K, C>),
    roundings: usize,
) -> SMatrix<f64, R, C> {
    let (a, b) = (a.abs(), b.abs());
    let (a_most, b_most) = (a + a_error, b + b_error);
    a_error * b_most + a * b_error + a_most * b_most * gamma(roundings)
}

pub(super) fn magnitudes(matrix: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)].abs())
}
