//! Ridge regression by normal equations.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Solves `(gram + ridge I) x = right`; no correction where rounding makes it indefinite.
pub(crate) fn solve_ridge(gram: &mut Mat<f64>, right: Mat<f64>, ridge: f64) -> Mat<f64> {
    for i in 0..gram.nrows() {
        gram[(i, i)] += ridge + f64::MIN_POSITIVE;
    }
    match gram.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => Mat::zeros(right.nrows(), right.ncols()),
    }
}
