//! Report of a fit.

use super::fit::Fit;
use super::options::Options;
use super::samples::{Merged, Samples};
use crate::regression::function::by_name;
use crate::scattered::bound::{largest, rounded};
use serde::Serialize;
use sinew_runtime::kernel::Kernel;

/// Options, quality and f32 error of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct FitReport {
    /// Number of samples, after merging.
    pub samples: usize,
    /// Number of columns of the sites.
    pub inputs: usize,
    /// Number of columns of the values.
    pub values: usize,
    /// Rows that were merged into earlier rows.
    pub merged: Vec<Merged>,
    /// Columns of the sites that do not count, because they hardly change or have no weight.
    pub dropped: Vec<usize>,
    /// Kernel G.
    #[serde(serialize_with = "by_name")]
    pub kernel: Kernel,
    /// Factor of distances whose mean is 1.
    pub epsilon: f64,
    /// Smoothing λ of all samples; the largest λ if each sample has its own.
    pub smoothing: f64,
    /// Number of centres.
    pub centres: usize,
    /// Degree in the options.
    pub degree_asked: Option<usize>,
    /// Degree of the fit: lower if there are too few samples.
    pub degree: Option<usize>,
    /// Number of monomials.
    pub terms: usize,
    /// Number of independent monomials at the samples.
    pub rank: usize,
    /// Reciprocal condition of the solved system, in the 1-norm.
    pub rcond: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// RMS residual of the values at the samples.
    pub residual_rms: f64,
    /// Largest residual.
    pub residual_max: f64,
    /// RMS error of samples that the others predict.
    pub left_out_rms: Option<f64>,
    /// Error of each sample that the others predict, RMS over its values; `None` if the others determine no fit.
    pub left_out: Vec<Option<f64>>,
    /// Bound of the f32 error of each value: E of METHOD §2.7 over the samples and their box.
    pub bounds: Vec<f64>,
}

impl FitReport {
    /// Reports a fit.
    pub fn new(samples: &Samples, options: &Options, fit: &Fit) -> Self {
        let Fit { sum, residuals, .. } = fit;
        let left_out = fit.leave_one_out();
        let each = left_out.each();
        let squares: Option<Vec<f64>> = each.iter().map(|e| Some((*e)?.powi(2))).collect();
        let numbers = (residuals.nrows() * residuals.ncols()) as f64;
        Self {
            samples: samples.sample_len(),
            inputs: samples.sites.ncols(),
            values: samples.values.ncols(),
            merged: samples.merged.clone(),
            dropped: samples.scaling.dropped(),
            kernel: sum.kernel,
            epsilon: options.epsilon,
            smoothing: options.smoothing + samples.smoothing.iter().copied().fold(0.0, f64::max),
            centres: sum.centres.ncols(),
            degree_asked: options.degree,
            degree: fit.degree,
            terms: sum.terms.len(),
            rank: fit.rank,
            rcond: fit.rcond,
            freedom: left_out.freedom,
            residual_rms: (residuals.squared_norm_l2() / numbers).sqrt(),
            residual_max: residuals.norm_max(),
            left_out_rms: squares.map(|s| (s.iter().sum::<f64>() / s.len() as f64).sqrt()),
            left_out: each,
            bounds: largest(&rounded(sum), &samples.sites),
        }
    }
}
