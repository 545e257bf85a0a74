//! A block of samples left out of a linear fit, in closed form (METHOD §2.2).
//!
//! A fit to all samples leaves `r = R y` of their outputs y, R = I - H with H the hat matrix. A fit
//! without the samples of a block I misses them by `e_I = (R_II)⁻¹ r_I`.

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};

/// What turns residuals of a block into errors of a fit that has not seen it.
pub struct LeftOut {
    remainder: Llt<f64>,
}

impl LeftOut {
    /// Takes R_II, of which the lower triangle is read, or a multiple of it where residuals are the same multiple of
    /// theirs; none where rounding has made it indefinite.
    pub fn new(remainder: &Mat<f64>) -> Option<Self> {
        Some(Self { remainder: remainder.llt(Side::Lower).ok()? })
    }

    /// Turns residuals r_I into errors; a row a sample, a column an output.
    pub fn errors(&self, residuals: &Mat<f64>) -> Mat<f64> {
        self.remainder.solve(residuals)
    }

    /// Returns what the variance of the fit without a sample's block is of that of its noise, plus 1.
    pub fn variances(&self) -> Vec<f64> {
        let inverse = self.remainder.inverse();
        inverse.diagonal().column_vector().iter().copied().collect()
    }

    /// Turns inner products of the samples' residuals, `r_I r_Iᵀ`, into those of their errors,
    /// `e_I e_Iᵀ`.
    pub fn products(&self, residuals: &Mat<f64>) -> Mat<f64> {
        let half = self.remainder.solve(residuals);
        self.remainder.solve(half.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inner_products_of_errors_are_those_of_the_errors() {
        let remainder = Mat::from_fn(3, 3, |i, j| if i == j { 0.9 } else { 0.1 * (i + j) as f64 });
        let residuals = Mat::from_fn(3, 2, |i, o| (i as f64 - 2.0 * o as f64).sin());
        let left_out = LeftOut::new(&remainder).unwrap();
        let errors = left_out.errors(&residuals);
        let found = left_out.products(&(&residuals * residuals.transpose()));
        assert!((found - &errors * errors.transpose()).norm_max() < 1e-12);
        assert!((&remainder * errors - residuals).norm_max() < 1e-12);
    }
}
