//! Errors of samples that a fit leaves out, and the variance of a fit between its samples.
//!
//! Samples are left out in closed form, alone or in groups (METHOD §2.2). The variance is that of a gaussian process
//! with the kernel as covariance, or generalised covariance (METHOD §2, §4).
//!
//! METHOD's variance is `G(0) - [g; p]ᵀ S⁻¹ [g; p]`, a difference of large numbers. Let B p be the weights that
//! reproduce the polynomials at a query, H = Bᵀ(K + Λ)B, and let A whiten `g - (K + Λ)B p`. Then the same variance is
//! `G(0) - 2 g·(B p) + p·(H p) - |A [g; p]|²`.

use super::matrix::some_rows;
use super::system::Solved;
use crate::regression::outputs::LeftOut;
use faer::Mat;

/// Least share of a sample that the other samples must leave undetermined; below it they determine no fit.
const DETERMINED: f64 = 1e-10;

/// Matrices that give the fit without some of its n samples.
pub struct LeaveOneOut {
    /// R of `r = R y`, or a multiple of R, n x n.
    remainder: Mat<f64>,
    /// Residuals r, or the same multiple of r, n x m.
    residuals: Mat<f64>,
    /// Orthonormal directions of the samples that a fit reproduces exactly, n x r.
    span: Mat<f64>,
    /// Effective degrees of freedom: the trace of the hat matrix.
    pub freedom: f64,
}

impl LeaveOneOut {
    /// Takes a fit with every sample a centre.
    ///
    /// The residuals are λ c. The coefficients c are the inverse's block times y, also if λ is 0.
    ///
    /// - `smoothing`: λ of each sample, n.
    pub fn of_solved(solved: &Solved, smoothing: &[f64]) -> Self {
        let remainder = solved.system.inverse();
        let left = smoothing.iter().enumerate().map(|(i, lambda)| lambda * remainder[(i, i)]);
        Self {
            freedom: solved.system.sample_len() as f64 - left.sum::<f64>(),
            residuals: solved.kernels.clone(),
            span: solved.system.span(),
            remainder,
        }
    }

    /// Takes a least-squares fit.
    ///
    /// - `h`: factor of the hat matrix `h hᵀ`, n x k.
    /// - `residuals`: n x m.
    pub fn of_hat(h: Mat<f64>, residuals: Mat<f64>) -> Self {
        let n = h.nrows();
        Self {
            freedom: h.squared_norm_l2(),
            remainder: Mat::<f64>::identity(n, n) - &h * h.transpose(),
            residuals,
            span: h,
        }
    }

    /// Returns the errors of a group of samples, a row each: values less predictions of the fit without the group.
    /// `None` if the other samples do not determine a fit.
    pub fn errors(&self, group: &[usize]) -> Option<Mat<f64>> {
        let span = some_rows(&self.span, group);
        let free = Mat::<f64>::identity(group.len(), group.len()) - &span * span.transpose();
        let factor = free.llt(faer::Side::Lower).ok()?;
        if factor.L().diagonal().column_vector().iter().any(|l| l * l < DETERMINED) {
            return None;
        }
        let own =
            Mat::from_fn(group.len(), group.len(), |i, k| self.remainder[(group[i], group[k])]);
        Some(LeftOut::new(&own)?.errors(&some_rows(&self.residuals, group)))
    }

    /// Returns the error of each sample that the others predict: RMS over its values.
    pub fn each(&self) -> Vec<Option<f64>> {
        let rms = |i: usize| {
            let errors = self.errors(&[i])?;
            Some((errors.squared_norm_l2() / errors.ncols() as f64).sqrt())
        };
        (0..self.residuals.nrows()).map(rms).collect()
    }

    /// Returns the mean square of the errors of each value, m, over all samples of the groups; `None` if a group cannot
    /// be left out.
    ///
    /// Each group is predicted without its samples.
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

/// Variance of a function of n centres and T monomials.
#[derive(Clone, Debug)]
pub struct Variance {
    /// Whitening matrix A, r x (n + T).
    pub whitening: Mat<f64>,
    /// Reproducing matrix B, n x T.
    pub reproducing: Mat<f64>,
    /// Polynomial matrix H, T x T.
    pub polynomial: Mat<f64>,
    /// Standard deviation of each value, the unit of its variance, m.
    pub deviations: Vec<f64>,
}

impl Variance {
    /// Computes the variance of a fit to values (n x m); `None` if the system is indefinite.
    ///
    /// The standard deviation of a value is the most likely one, `√(c·y / (n - r))`, with the rank r of the
    /// polynomials.
    pub fn new(solved: &Solved, values: &Mat<f64>) -> Option<Self> {
        let (system, basis) = (&solved.system, &solved.polynomial.basis);
        let reproducing = system.reproducing() * basis.transpose();
        let smoothed = &solved.matrix * &reproducing;
        let n = system.sample_len();
        let of_kernels = system.whitened(&Mat::identity(n, n))?;
        let whitening = faer::concat![[&of_kernels, &of_kernels * &smoothed * faer::Scale(-1.0)]];
        let free = (n - system.rank()).max(1) as f64;
        let deviation = |o: usize| {
            let energy: f64 = solved.kernels.col(o).transpose() * values.col(o);
            (energy.max(0.0) / free).sqrt()
        };
        Some(Self {
            whitening,
            polynomial: reproducing.transpose() * &smoothed,
            reproducing,
            deviations: (0..values.ncols()).map(deviation).collect(),
        })
    }
}
