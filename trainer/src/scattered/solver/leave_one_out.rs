//! Every sample, or group of them, predicted by a fit without it, in closed form (METHOD §2.2).

use super::solve::Solved;
use crate::regression::left_out::LeftOut;
use faer::Mat;

/// Share of a sample that the others must leave to its own error, below which they do not determine
/// the fit.
const DETERMINED: f64 = 1e-10;

/// What a fit with n samples knows of being without some of them.
pub struct LeaveOneOut {
    /// R of `r = R y`, or a multiple of it, n x n.
    remainder: Mat<f64>,
    /// r, or the same multiple of it, n x m.
    residuals: Mat<f64>,
    /// Orthonormal directions of the samples that a fit follows whatever they are, n x r.
    followed: Mat<f64>,
    /// Effective degrees of freedom: the trace of what turns values into those of the fit.
    pub freedom: f64,
}

impl LeaveOneOut {
    /// Takes a fit with every sample a centre, smoothed by λ (n): residuals are λ c there, and c is
    /// the inverse's block times y also where λ is 0.
    pub fn of_solved(solved: &Solved, smoothing: &[f64]) -> Self {
        let remainder = solved.system.inverse();
        let left = smoothing.iter().enumerate().map(|(i, lambda)| lambda * remainder[(i, i)]);
        Self {
            freedom: solved.system.sample_len() as f64 - left.sum::<f64>(),
            residuals: solved.kernels.clone(),
            followed: solved.system.followed(),
            remainder,
        }
    }

    /// Takes a least-squares fit of residuals r whose hat matrix is `h hᵀ`, h n x k.
    pub fn of_hat(h: Mat<f64>, residuals: Mat<f64>) -> Self {
        let n = h.nrows();
        Self {
            freedom: h.squared_norm_l2(),
            remainder: Mat::<f64>::identity(n, n) - &h * h.transpose(),
            residuals,
            followed: h,
        }
    }

    /// Finds the errors of a group of samples, values less predictions of the fit without them, a row
    /// each; none where the others do not determine a fit.
    pub fn errors(&self, group: &[usize]) -> Option<Mat<f64>> {
        let rows = |m: &Mat<f64>| Mat::from_fn(group.len(), m.ncols(), |i, c| m[(group[i], c)]);
        let followed = rows(&self.followed);
        let free =
            Mat::<f64>::identity(group.len(), group.len()) - &followed * followed.transpose();
        let factor = free.llt(faer::Side::Lower).ok()?;
        if factor.L().diagonal().column_vector().iter().any(|l| l * l < DETERMINED) {
            return None;
        }
        let own =
            Mat::from_fn(group.len(), group.len(), |i, k| self.remainder[(group[i], group[k])]);
        Some(LeftOut::new(&own)?.errors(&rows(&self.residuals)))
    }

    /// Finds the error of each sample, predicted by the others: RMS over its values.
    pub fn each(&self) -> Vec<Option<f64>> {
        let rms = |i: usize| {
            let errors = self.errors(&[i])?;
            Some((errors.squared_norm_l2() / errors.ncols() as f64).sqrt())
        };
        (0..self.residuals.nrows()).map(rms).collect()
    }

    /// Finds the errors of groups, each predicted without its own: mean squares of each value over
    /// all samples of the groups, m; none where a group cannot be left out.
    pub fn mean_squares(&self, groups: &[Vec<usize>]) -> Option<Vec<f64>> {
        let mut sums = vec![0.0; self.residuals.ncols()];
        for group in groups {
            let errors = self.errors(group)?;
            sums.iter_mut().zip(errors.col_iter()).for_each(|(s, e)| *s += e.squared_norm_l2());
        }
        let samples: usize = groups.iter().map(Vec::len).sum();
        sums.iter_mut().for_each(|sum| *sum /= samples as f64);
        Some(sums)
    }
}
