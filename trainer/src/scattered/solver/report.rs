//! Report of a fit.

use super::fit::{AnyFit, FewerFit, Fit};
use super::leave_one_out::LeaveOneOut;
use super::options::Options;
use super::samples::{Merged, Samples};
use crate::regression::function::by_name;
use crate::scattered::bound::{largest, rounded};
use crate::scattered::sum::KernelSum;
use faer::Mat;
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
    /// Reports a fit of either kind.
    pub fn of_any(samples: &Samples, options: &Options, fit: &AnyFit) -> Self {
        match fit {
            AnyFit::Every(fit) => Self::new(samples, options, fit),
            AnyFit::Fewer(fit) => Self::of_fewer(samples, options, fit),
        }
    }

    /// Reports a fit with every sample a centre.
    pub fn new(samples: &Samples, options: &Options, fit: &Fit) -> Self {
        let solved = &fit.solved;
        Self::of(
            samples,
            options,
            Parts {
                sum: &fit.sum,
                residuals: &solved.residuals,
                left_out: &fit.leave_one_out(),
                degree: solved.polynomial.degree,
                rank: solved.polynomial.rank(),
                rcond: solved.system.rcond(),
            },
        )
    }

    /// Reports a fit of fewer centres.
    pub fn of_fewer(samples: &Samples, options: &Options, fit: &FewerFit) -> Self {
        Self::of(
            samples,
            options,
            Parts {
                sum: &fit.sum,
                residuals: &fit.residuals,
                left_out: &fit.leave_one_out(),
                degree: fit.degree,
                rank: fit.rank,
                rcond: fit.rcond,
            },
        )
    }

    fn of(samples: &Samples, options: &Options, parts: Parts<'_>) -> Self {
        let Parts { sum, residuals, left_out, degree, rank, rcond } = parts;
        let each = left_out.each();
        let squares: Option<Vec<f64>> = each.iter().map(|e| Some((*e)?.powi(2))).collect();
        let bounds = largest(&rounded(sum), &samples.sites);
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
            degree,
            terms: sum.terms.len(),
            rank,
            rcond,
            freedom: left_out.freedom,
            residual_rms: rms(residuals),
            residual_max: residuals.norm_max(),
            left_out_rms: squares.map(|s| (s.iter().sum::<f64>() / s.len() as f64).sqrt()),
            left_out: each,
            bounds,
        }
    }
}

/// Common results of all fits.
struct Parts<'a> {
    sum: &'a KernelSum,
    residuals: &'a Mat<f64>,
    left_out: &'a LeaveOneOut,
    degree: Option<usize>,
    rank: usize,
    rcond: f64,
}

fn rms(of: &Mat<f64>) -> f64 {
    (of.squared_norm_l2() / (of.nrows() * of.ncols()) as f64).sqrt()
}
