//! Regression targets, blocks of samples that are left out, and the error of a fit without a block.
//!
//! A fit without a block is known in closed form (METHOD §2.2). A fit to all samples has the residuals `r = R y` of the
//! outputs y, with R = I - H and the hat matrix H. The fit without the samples of a block I has the errors `e_I =
//! (R_II)⁻¹ r_I` at these samples.

use crate::numeric::columns::some;
use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};
use std::ops::Range;

/// Power of the mean over blocks. A power near 0 makes the mean geometric, so the hardest block does not decide alone.
const POWER: f64 = 0.1;

/// Samples that are left out together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Samples that are predicted.
    pub own: Vec<usize>,
    /// Samples near them, which the fit leaves out but does not predict.
    pub near: Vec<usize>,
}

impl Block {
    /// Makes a block of consecutive samples, with no samples near them.
    pub fn row(own: Range<usize>) -> Self {
        Self { own: own.collect(), near: Vec::new() }
    }

    /// Counts the samples that are left out.
    pub fn out_len(&self) -> usize {
        self.own.len() + self.near.len()
    }

    /// Lists the samples that are left out: the predicted samples first.
    pub fn out(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.own.iter().chain(&self.near).copied()
    }

    /// Lists the samples, of n, that are not left out.
    pub fn others(&self, n: usize) -> Vec<usize> {
        let mut is_other = vec![true; n];
        self.out().for_each(|sample| is_other[sample] = false);
        (0..n).filter(|&sample| is_other[sample]).collect()
    }

    /// Collects the rows of the samples that are left out.
    pub fn rows(&self, all: &Mat<f64>) -> Mat<f64> {
        let mut rows = Mat::zeros(self.out_len(), all.ncols());
        for (out, all) in rows.col_iter_mut().zip(all.col_iter()) {
            out.iter_mut().zip(self.out()).for_each(|(out, sample)| *out = all[sample]);
        }
        rows
    }
}

/// Regression targets and the blocks that validate a fit.
pub struct Outputs {
    /// Targets, n x r.
    pub all: Mat<f64>,
    /// Blocks of samples. The first blocks cover all samples.
    pub blocks: Vec<Block>,
    /// Parts of the first blocks, left out one at a time to estimate a fit's error.
    pub parts: Vec<Block>,
    /// Number of blocks with extreme samples, which the others predict by extrapolation: the last blocks.
    pub extrapolated_len: usize,
    /// Squared error without any fit, summed over the samples.
    pub signal: f64,
    /// Squared error of a sample that counts as no error.
    pub negligible: f64,
    /// Largest number of a map's variance roots.
    pub root_limit: usize,
}

impl Outputs {
    /// Returns some columns of the targets.
    #[must_use]
    pub fn columns(&self, columns: &[usize]) -> Self {
        Self {
            all: some(&self.all, columns),
            blocks: self.blocks.clone(),
            parts: self.parts.clone(),
            ..*self
        }
    }

    /// Joins several targets of the same samples, side by side.
    ///
    /// # Panics
    /// If `several` is empty.
    #[must_use]
    pub fn beside(several: &[Self]) -> Self {
        let columns: Vec<_> = several.iter().flat_map(|own| own.all.col_iter()).collect();
        let first = &several[0];
        Self {
            all: Mat::from_fn(first.all.nrows(), columns.len(), |i, k| columns[k][i]),
            blocks: first.blocks.clone(),
            parts: first.parts.clone(),
            signal: several.iter().map(|own| own.signal).sum(),
            ..*first
        }
    }

    /// Returns the score of predicting 0: the magnitude of each target in the blocks.
    pub fn sizes(&self) -> Vec<f64> {
        let size = |o: usize| {
            power_mean(self.blocks.iter().map(|block| {
                let own = block.own.iter().map(|&sample| self.all[(sample, o)].powi(2));
                own.sum::<f64>()
            }))
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// Returns the power mean of the squared errors of blocks.
pub fn power_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(POWER)));
    (sum / f64::from(count.max(1))).powf(1.0 / POWER)
}

/// Factor that converts residuals of a block into errors of a fit without the block.
pub struct LeftOut {
    remainder: Llt<f64>,
}

impl LeftOut {
    /// Factors R_II; `None` if rounding has made the matrix indefinite.
    ///
    /// A multiple of R_II also serves, if the residuals have the same factor. Only the lower triangle is read.
    pub fn new(remainder: &Mat<f64>) -> Option<Self> {
        Some(Self { remainder: remainder.llt(Side::Lower).ok()? })
    }

    /// Converts residuals r_I into errors; a row a sample, a column an output.
    pub fn errors(&self, residuals: &Mat<f64>) -> Mat<f64> {
        self.remainder.solve(residuals)
    }

    /// Returns 1 plus the variance of the fit without each sample's block, over the variance of the noise.
    pub fn variances(&self) -> Vec<f64> {
        let inverse = self.remainder.inverse();
        inverse.diagonal().column_vector().iter().copied().collect()
    }

    /// Converts inner products of residuals, `r_I r_Iᵀ`, into inner products of errors, `e_I e_Iᵀ`.
    pub fn products(&self, residuals: &Mat<f64>) -> Mat<f64> {
        let half = self.remainder.solve(residuals);
        self.remainder.solve(half.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_residuals_become_products_of_errors() {
        let remainder = Mat::from_fn(3, 3, |i, j| if i == j { 0.9 } else { 0.1 * (i + j) as f64 });
        let residuals = Mat::from_fn(3, 2, |i, o| (i as f64 - 2.0 * o as f64).sin());
        let left_out = LeftOut::new(&remainder).unwrap();
        let errors = left_out.errors(&residuals);
        let found = left_out.products(&(&residuals * residuals.transpose()));
        assert!((found - &errors * errors.transpose()).norm_max() < 1e-12);
        assert!((&remainder * errors - residuals).norm_max() < 1e-12);
    }
}
