//! Solves the linear systems of kriging: a matrix of covariances and a basis of the mean (METHOD §4).
//!
//! METHOD computes m = 1ᵀK⁻¹f₀/1ᵀK⁻¹1, and the variance as a difference of large numbers. To avoid the cancellation,
//! this module uses weights B that reproduce the mean's basis, as `scattered::solver::leave_one_out::Variance` does.

use crate::Error;
use crate::scattered::solver::fit::{MISSED, RCOND};
use crate::scattered::solver::refusal::described;
use crate::scattered::solver::system::System;
use faer::Mat;

/// Suggested change if the covariances of values are ill-conditioned.
pub(super) const REMEDY: &str = "take a shorter length, a rougher covariance, or a noise";

/// A solved system of n observations.
///
/// Variances of values, derivatives and averages have different units. So the system DKD is solved, with D =
/// diag(K)^(-1/2). Its condition number does not depend on the units.
pub struct Solved {
    /// Diagonal of D, n.
    units: Vec<f64>,
    /// DKD with K = C₀ + τI, n x n.
    matrix: Mat<f64>,
    system: System,
    /// B for the scaled basis DP, n x r.
    reproducing: Mat<f64>,
    /// D times the solution of the scaled system, n x 1: coefficients of the covariances.
    kernels: Mat<f64>,
    terms: Mat<f64>,
    energy: f64,
}

impl Solved {
    /// Solves for values (n) with covariance K (n x n) and the mean's basis (n x r).
    ///
    /// # Errors
    /// The reciprocal condition, if rounding errors dominate the solution.
    pub fn new(matrix: Mat<f64>, basis: &Mat<f64>, values: &[f64]) -> Result<Self, f64> {
        let n = matrix.nrows();
        let units: Vec<f64> = (0..n).map(|i| 1.0 / matrix[(i, i)].sqrt()).collect();
        let matrix = Mat::from_fn(n, n, |i, k| units[i] * matrix[(i, k)] * units[k]);
        let basis = Mat::from_fn(n, basis.ncols(), |i, t| units[i] * basis[(i, t)]);
        let system = System::new(&matrix, &basis);
        let rcond = system.rcond();
        if rcond.is_nan() || rcond < RCOND {
            return Err(rcond);
        }
        let y = scaled(values, &units);
        // Only rounding makes a covariance matrix indefinite.
        let whitened = system.whitened(&y).ok_or(rcond)?;
        let (kernels, terms) = system.solve(&y);
        // If two observations of the same quantity disagree, the mean can hide the contradiction: the remaining system
        // is well-conditioned but consists of rounding errors.
        let missed = (&y - &matrix * &kernels - basis * &terms).norm_max();
        if missed.is_nan() || missed > MISSED * y.norm_max() {
            return Err(rcond);
        }
        let reproducing = system.reproducing();
        let kernels = Mat::from_fn(n, 1, |i, _| units[i] * kernels[(i, 0)]);
        let energy = whitened.squared_norm_l2();
        Ok(Self { units, matrix, reproducing, kernels, terms, energy, system })
    }

    /// Returns the coefficients of the covariances, n, and of the mean's basis, r.
    pub fn coefficients(&self) -> (Vec<f64>, Vec<f64>) {
        let list = |of: &Mat<f64>| of.col(0).iter().copied().collect();
        (list(&self.kernels), list(&self.terms))
    }

    /// Estimates the likeliest factor of the covariances; 0 if the mean fits the values exactly.
    pub fn scale(&self) -> f64 {
        let free = self.matrix.nrows() - self.terms.nrows();
        if free == 0 { 0.0 } else { self.energy / free as f64 }
    }

    /// Predicts a value.
    ///
    /// - `r`: covariances with the observations, n.
    /// - `p`: the mean's basis functions, r.
    pub fn value(&self, r: &[f64], p: &[f64]) -> f64 {
        dot(r, &self.kernels) + dot(p, &self.terms)
    }

    /// Computes the weight of each observation in the prediction of [`Self::value`], n.
    pub fn weights(&self, r: &[f64], p: &[f64]) -> Vec<f64> {
        let followed = &self.reproducing * column(p);
        let left = scaled(r, &self.units) - &self.matrix * &followed;
        let (kernels, _) = self.system.solve(&left);
        let weights = followed + kernels;
        self.units.iter().zip(weights.col(0).iter()).map(|(unit, weight)| unit * weight).collect()
    }

    /// Computes the variance of the prediction of [`Self::value`]; never below 0.
    ///
    /// - `own`: prior variance of the predicted value.
    pub fn variance(&self, own: f64, r: &[f64], p: &[f64]) -> f64 {
        let (r, followed) = (scaled(r, &self.units), &self.reproducing * column(p));
        let smoothed = &self.matrix * &followed;
        let linear = (r.transpose() * &followed)[(0, 0)];
        let square = (followed.transpose() * &smoothed)[(0, 0)];
        let explained = self.system.whitened(&(r - smoothed)).map_or(0.0, |x| x.squared_norm_l2());
        (own - 2.0 * linear + square - explained).max(0.0)
    }
}

/// Returns the error of observations whose covariances are ill-conditioned.
///
/// - `redundant`: the first observation that is nearly redundant, in words.
/// - `remedy`: suggested change.
pub(super) fn ill_conditioned(rcond: f64, redundant: Option<String>, remedy: &str) -> Error {
    let redundant = redundant.map_or(String::new(), |redundant| format!(": {redundant}"));
    Error::fit(format!(
        "the observations' covariance is ill-conditioned ({}){redundant}: {remedy}",
        described(rcond)
    ))
}

fn column(of: &[f64]) -> Mat<f64> {
    Mat::from_fn(of.len(), 1, |i, _| of[i])
}

fn scaled(of: &[f64], units: &[f64]) -> Mat<f64> {
    Mat::from_fn(of.len(), 1, |i, _| units[i] * of[i])
}

fn dot(a: &[f64], b: &Mat<f64>) -> f64 {
    a.iter().zip(b.col(0).iter()).map(|(a, b)| a * b).sum()
}
