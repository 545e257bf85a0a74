//! Values at samples, every sample a centre, solved for a sum of kernels and a polynomial (METHOD §2.2).

use super::matrix::gram;
use super::polynomial::Polynomial;
use super::samples::{OFFSET, ranges};
use super::system::System;
use faer::{ColRef, Mat};
use sinew_runtime::kernel::Kernel;

/// Share of the values' range above which missed equations are solved once more for what is left: a digit
/// at most (*measured*), where few are left.
const REFINED: f64 = 1e-12;

/// A solution, and what it was solved with.
pub struct Solved {
    /// The factors.
    pub system: System,
    /// The polynomials.
    pub polynomial: Polynomial,
    /// Coefficients of the kernels, n x m.
    pub kernels: Mat<f64>,
    /// Coefficients of the monomials, T x m.
    pub monomials: Mat<f64>,
    /// K + Λ, n x n.
    pub matrix: Mat<f64>,
    /// What the function leaves of the values, n x m.
    pub residuals: Mat<f64>,
    /// By how much equations are missed at most, over the range of the values.
    pub missed: f64,
}

/// Solves for values (n x m) at points (n x d), each smoothed by λ (n).
pub fn solve(
    kernel: Kernel,
    points: &Mat<f64>,
    smoothing: &[f64],
    polynomial: Polynomial,
    values: &Mat<f64>,
) -> Solved {
    let mut matrix = gram(kernel, points);
    smoothing.iter().enumerate().for_each(|(i, lambda)| matrix[(i, i)] += lambda);
    let system = System::new(&matrix, &polynomial.values);
    // A large offset leaves its rounding in the equations.
    let offsets = values.col_iter().map(|column| OFFSET * column.norm_max());
    let ranges: Vec<f64> = ranges(values).into_iter().zip(offsets).map(|(r, o)| r.max(o)).collect();
    let of = |(kernels, basis): (Mat<f64>, Mat<f64>)| {
        let error = values - &matrix * &kernels - &polynomial.values * &basis;
        let missed = over(&error, &ranges);
        (kernels, basis, error, missed)
    };
    let mut found = of(system.solve(values));
    if found.3 > REFINED {
        let (kernels, basis) = system.solve(&found.2);
        let refined = of((&found.0 + kernels, &found.1 + basis));
        found = if refined.3 < found.3 { refined } else { found };
    }
    let (kernels, basis, error, missed) = found;
    let residuals = Mat::from_fn(error.nrows(), error.ncols(), |i, o| {
        error[(i, o)] + smoothing[i] * kernels[(i, o)]
    });
    let monomials = &polynomial.basis * basis;
    Solved { system, polynomial, kernels, monomials, matrix, residuals, missed }
}

/// Returns the largest error over the range of its value; what is not a number is infinite.
fn over(errors: &Mat<f64>, ranges: &[f64]) -> f64 {
    let of = |(column, range): (ColRef<'_, f64>, &f64)| {
        let share = |error: &f64| if error.is_nan() { f64::INFINITY } else { error.abs() / range };
        column.iter().map(share).fold(0.0, f64::max)
    };
    errors.col_iter().zip(ranges).map(of).fold(0.0, f64::max)
}
