//! Fits among the functions that a few others span, under any norm (S0 Eq. 15, Prop. 3).
//!
//! Of f = Σ c_i h_i a positive definite S makes a norm, ‖f‖² = cᵀSc. It has a reproducing kernel of its own,
//! K(p, q) = h(p)ᵀS⁻¹h(q). With h_i the covariances of observations and S their own matrix C₀, this is kriging.

use super::error::SignalError;
use faer::linalg::solvers::{Solve, SolveLstsq};
use faer::{Mat, Side};

/// A norm of functions of a span.
pub struct Norm {
    s: Mat<f64>,
    llt: faer::linalg::solvers::Llt<f64>,
}

impl Norm {
    /// Takes S, n x n.
    ///
    /// # Errors
    /// [`SignalError::Indefinite`].
    pub fn new(s: Mat<f64>) -> Result<Self, SignalError> {
        let llt = s.llt(Side::Lower).map_err(|_| SignalError::Indefinite { what: "the norm S" })?;
        Ok(Self { s, llt })
    }

    /// Computes the coefficients, n, of the f with the least `|H c - y|² + β cᵀSc`, H the observations of the h_i
    /// (m x n), y what they are to be (m).
    ///
    /// By QR of `[H; √β Lᵀ]`, S = LLᵀ: no normal equations.
    pub fn fit(&self, observed: &Mat<f64>, values: &[f64], beta: f64) -> Vec<f64> {
        let (m, n) = observed.shape();
        let penalty = self.llt.L().transpose() * faer::Scale(beta.sqrt());
        let matrix = faer::concat![[observed], [&penalty]];
        let right = Mat::from_fn(m + n, 1, |i, _| values.get(i).copied().unwrap_or(0.0));
        matrix.qr().solve_lstsq(&right).col(0).iter().copied().collect()
    }

    /// Computes the inner product of two functions by their coefficients, n each.
    pub fn inner(&self, a: &[f64], b: &[f64]) -> f64 {
        let column = |of: &[f64]| Mat::from_fn(of.len(), 1, |i, _| of[i]);
        (column(a).transpose() * &self.s * column(b))[(0, 0)]
    }

    /// Computes the coefficients of K(·, q), n, of the values of the h_i at q.
    pub fn reproducing(&self, at: &[f64]) -> Vec<f64> {
        let right = Mat::from_fn(at.len(), 1, |i, _| at[i]);
        self.llt.solve(right).col(0).iter().copied().collect()
    }
}
