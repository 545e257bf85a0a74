//! What samples are to give, in blocks, and the mean by which errors of blocks make a score.
//! A block of samples left out of a linear fit, in closed form (METHOD §2.2).
//!
//! A fit to all samples leaves `r = R y` of their outputs y, R = I - H with H the hat matrix. A fit
//! without the samples of a block I misses them by `e_I = (R_II)⁻¹ r_I`.

use crate::numeric::columns::some;
use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};
use std::ops::Range;

/// Power of the mean over blocks. Near 0 the mean is geometric, so that the hardest block does not decide alone.
const GENTLE: f64 = 0.1;

/// Samples that are left out at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Those that are predicted.
    pub own: Vec<usize>,
    /// Others that the fit that predicts them does not see either.
    pub near: Vec<usize>,
}

impl Block {
    /// A block of samples in a row, with nothing near.
    pub fn row(own: Range<usize>) -> Self {
        Self { own: own.collect(), near: Vec::new() }
    }

    /// Counts what is left out.
    pub fn out_len(&self) -> usize {
        self.own.len() + self.near.len()
    }

    /// Lists what is left out: its own first.
    pub fn out(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.own.iter().chain(&self.near).copied()
    }

    /// Lists those of n samples that are not left out.
    pub fn others(&self, n: usize) -> Vec<usize> {
        let mut is_other = vec![true; n];
        self.out().for_each(|sample| is_other[sample] = false);
        (0..n).filter(|&sample| is_other[sample]).collect()
    }

    /// Takes the rows of what is left out.
    pub fn rows(&self, all: &Mat<f64>) -> Mat<f64> {
        let mut rows = Mat::zeros(self.out_len(), all.ncols());
        for (out, all) in rows.col_iter_mut().zip(all.col_iter()) {
            out.iter_mut().zip(self.out()).for_each(|(out, sample)| *out = all[sample]);
        }
        rows
    }
}

/// What the samples are to give.
pub struct Outputs {
    /// n x r.
    pub all: Mat<f64>,
    /// Blocks of samples, of which the first ones cover all.
    pub blocks: Vec<Block>,
    /// Parts of the first blocks, left out one at a time to estimate a fit's error.
    pub parts: Vec<Block>,
    /// How many blocks, the last, are of samples beyond the others.
    pub beyond: usize,
    /// The squared size, summed over the samples, of what would be left without any fit.
    pub signal: f64,
    /// The squared size in a sample that counts as nothing.
    pub negligible: f64,
    /// Most values of a map's certainty.
    pub certainty: usize,
}

impl Outputs {
    /// Returns some of the outputs.
    #[must_use]
    pub fn columns(&self, columns: &[usize]) -> Self {
        Self {
            all: some(&self.all, columns),
            blocks: self.blocks.clone(),
            parts: self.parts.clone(),
            ..*self
        }
    }

    /// Several outputs of the same samples side by side.
    ///
    /// # Panics
    /// If there is none.
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

    /// Scores of predicting nothing: each output's size in the blocks.
    pub fn sizes(&self) -> Vec<f64> {
        let size = |o: usize| {
            gentle_mean(self.blocks.iter().map(|block| {
                let own = block.own.iter().map(|&sample| self.all[(sample, o)].powi(2));
                own.sum::<f64>()
            }))
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// Returns the power mean of the squared errors of blocks.
pub fn gentle_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(GENTLE)));
    (sum / f64::from(count.max(1))).powf(1.0 / GENTLE)
}

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
