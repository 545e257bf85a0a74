//! How unsure a function is between its samples: the variance of a gaussian process with its kernel as
//! covariance, or generalised covariance (METHOD §2, §4).
//!
//! METHOD has `G(0) - [g; p]ᵀ S⁻¹ [g; p]`, a difference of large numbers. With the weights B p that
//! reproduce the polynomials at a query, the same is
//! `G(0) - 2 g·(B p) + p·(H p) - |A [g; p]|²`, H = Bᵀ(K + Λ)B and A what whitens `g - (K + Λ)B p`.

use super::fit::Fit;
use crate::regression::function::Exact;
use crate::scattered::sum::KernelSum;
use faer::Mat;

/// What the variance of a function of n centres and T monomials is computed with.
#[derive(Clone, Debug)]
pub struct Variance {
    /// A, r x (n + T).
    pub whitening: Mat<f64>,
    /// B, n x T.
    pub reproducing: Mat<f64>,
    /// H, T x T.
    pub polynomial: Mat<f64>,
    /// Standard deviations that the values' variances are measured in, m.
    pub deviations: Vec<f64>,
}

impl Variance {
    /// Takes what a fit of values (n x m) knows; none where its system is indefinite.
    ///
    /// A deviation is the one under which the values are likeliest: `√(c·y / (n - r))`, r the rank of
    /// the polynomials.
    pub fn new(fit: &Fit, values: &Mat<f64>) -> Option<Self> {
        let solved = &fit.solved;
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

    /// Computes the variance of each value of a function at a query, m: never below 0.
    pub fn at(&self, sum: &KernelSum, x: &[f64]) -> Vec<f64> {
        let (g, p) = sum.basis(x);
        let column = |of: &[f64]| Mat::from_fn(of.len(), 1, |i, _| of[i]);
        let (g, p) = (column(&g), column(&p));
        let weights = &self.reproducing * &p;
        let explained = &self.whitening * faer::concat![[&g], [&p]];
        let linear = (g.transpose() * weights)[(0, 0)];
        let square = (p.transpose() * &self.polynomial * &p)[(0, 0)];
        let unit = sum.kernel.exact(0.0) - 2.0 * linear + square - explained.squared_norm_l2();
        self.deviations.iter().map(|deviation| deviation * deviation * unit.max(0.0)).collect()
    }
}
