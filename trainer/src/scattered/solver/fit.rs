//! A function from samples, every sample a centre (METHOD §2.2).

use super::error::KernelError;
use super::leave_one_out::LeaveOneOut;
use super::options::Options;
use super::prepared::Prepared;
use super::samples::Samples;
use super::solve::{Solved, solve};
use crate::scattered::sum::KernelSum;

/// Least reciprocal condition of a system that is solved: beyond, f64 has no digit left.
pub const RCOND: f64 = 1e-14;
/// Largest share of the values' range by which its equations may be missed: what METHOD §2.7 promises
/// of samples.
pub const MISSED: f64 = 1e-10;

/// A function, and what it was fitted with.
pub struct Fit {
    /// The function.
    pub sum: KernelSum,
    /// The solution.
    pub solved: Solved,
    /// λ of each sample, n.
    pub smoothing: Vec<f64>,
}

impl Fit {
    /// Fits samples.
    ///
    /// # Errors
    /// Those of [`Options::check`]; if rounding decides what the function is.
    pub fn new(samples: &Samples, options: &Options) -> Result<Self, KernelError> {
        options.check()?;
        let prepared = Prepared::new(samples, options);
        let smoothing: Vec<f64> =
            samples.smoothing.iter().map(|own| options.smoothing + own).collect();
        let Prepared { points, polynomial, .. } = &prepared;
        let solved = solve(options.kernel, points, &smoothing, polynomial.clone(), &samples.values);
        let (rcond, missed) = (solved.system.rcond(), solved.missed);
        if rcond < RCOND || missed > MISSED {
            return Err(KernelError::IllConditioned { rcond, missed });
        }
        let sum = prepared.sum(points, &solved.kernels, &solved.monomials);
        Ok(Self { sum, solved, smoothing })
    }

    /// Predicts samples by the fit without them.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        LeaveOneOut::of_solved(&self.solved, &self.smoothing)
    }
}
