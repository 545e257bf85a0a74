//! The system of observations, whatever they are of: a matrix of covariances and a basis of the mean (METHOD §4).
//!
//! METHOD has m = 1ᵀK⁻¹f₀/1ᵀK⁻¹1 and the variance as differences of large numbers; with the weights B that reproduce
//! the mean's basis they are as `kernel::scattered::variance` has them.

use super::error::SignalError;
use crate::scattered::solver::fit::{MISSED, RCOND};
use crate::scattered::solver::system::System;
use faer::Mat;

/// What to change where covariances of values are ill-conditioned.
const REMEDY: &str = "take a shorter length, a rougher covariance, or a noise";

/// Values of n observations, solved for.
///
/// Values, derivatives and averages have variances of different units. So DKD is solved, D = diag(K)^(-1/2): its
/// condition does not change with the units.
pub struct Solved {
    /// D, n.
    units: Vec<f64>,
    /// DKD, K = C₀ + τI, n x n.
    matrix: Mat<f64>,
    system: System,
    /// B of DP, n x r.
    reproducing: Mat<f64>,
    /// D times the coefficients of DKD, n x 1.
    kernels: Mat<f64>,
    terms: Mat<f64>,
    energy: f64,
}

impl Solved {
    /// Solves for values (n) of covariance K (n x n) about a mean of a basis (n x r).
    ///
    /// # Errors
    /// [`SignalError::IllConditioned`].
    pub fn new(matrix: Mat<f64>, basis: &Mat<f64>, values: &[f64]) -> Result<Self, SignalError> {
        let n = matrix.nrows();
        let units: Vec<f64> = (0..n).map(|i| 1.0 / matrix[(i, i)].sqrt()).collect();
        let matrix = Mat::from_fn(n, n, |i, k| units[i] * matrix[(i, k)] * units[k]);
        let basis = Mat::from_fn(n, basis.ncols(), |i, t| units[i] * basis[(i, t)]);
        let system = System::new(&matrix, &basis);
        let ill_conditioned =
            || SignalError::IllConditioned { rcond: system.rcond(), told: None, remedy: REMEDY };
        if system.rcond().is_nan() || system.rcond() < RCOND {
            return Err(ill_conditioned());
        }
        let y = scaled(values, &units);
        // A covariance is definite but for rounding.
        let whitened = system.whitened(&y).ok_or_else(ill_conditioned)?;
        let (kernels, terms) = system.solve(&y);
        // Of two observations of one thing that disagree the mean may leave a system of one rounding, which is well
        // conditioned.
        let missed = (&y - &matrix * &kernels - basis * &terms).norm_max();
        if missed.is_nan() || missed > MISSED * y.norm_max() {
            return Err(ill_conditioned());
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

    /// Estimates the number by which covariances are to be multiplied: that under which the values are likeliest;
    /// 0 of values that the mean follows.
    pub fn scale(&self) -> f64 {
        let free = self.matrix.nrows() - self.terms.nrows();
        if free == 0 { 0.0 } else { self.energy / free as f64 }
    }

    /// Predicts what has covariances r (n) with the observations and numbers p (r) in the mean's basis.
    pub fn value(&self, r: &[f64], p: &[f64]) -> f64 {
        dot(r, &self.kernels) + dot(p, &self.terms)
    }

    /// Computes how much each observation counts for the same, n.
    pub fn weights(&self, r: &[f64], p: &[f64]) -> Vec<f64> {
        let followed = &self.reproducing * column(p);
        let left = scaled(r, &self.units) - &self.matrix * &followed;
        let (kernels, _) = self.system.solve(&left);
        let weights = followed + kernels;
        self.units.iter().zip(weights.col(0).iter()).map(|(unit, weight)| unit * weight).collect()
    }

    /// Computes the variance of the same, whose own is given: never below 0.
    pub fn variance(&self, own: f64, r: &[f64], p: &[f64]) -> f64 {
        let (r, followed) = (scaled(r, &self.units), &self.reproducing * column(p));
        let smoothed = &self.matrix * &followed;
        let linear = (r.transpose() * &followed)[(0, 0)];
        let square = (followed.transpose() * &smoothed)[(0, 0)];
        let explained = self.system.whitened(&(r - smoothed)).map_or(0.0, |x| x.squared_norm_l2());
        (own - 2.0 * linear + square - explained).max(0.0)
    }
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
