//! Results of a training.

use crate::scattered::model::{Figures, KernelModel};
use crate::scattered::solver::leave_one_out::Variance;
use crate::scattered::solver::report::FitReport;
use crate::scattered::sum::KernelSum;
use serde::Serialize;

/// Fitted function and its report.
pub struct Trained {
    /// Fitted function.
    pub model: KernelModel,
    /// Report of the fit.
    pub report: Report,
    /// Largest deviation of the file from f64, over the range of the value, at the samples and at 1,000 queries between
    /// them.
    pub deviation: f64,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Report of a fit.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// Fit by METHOD §2.
    Fit(Box<FitReport>),
    /// Fit with learned centres.
    Learned(LearnReport),
    /// Fit by the rules of another solver.
    Mode {
        /// Reciprocal condition of the solved system.
        rcond: f64,
        /// RMS residual of the values at the samples.
        residual_rms: f64,
    },
}

/// Report of learned centres and metric.
#[derive(Clone, Debug, Serialize)]
pub struct LearnReport {
    /// Energy of the function.
    pub energy: f64,
    /// RMS residual of the values at the samples.
    pub residual_rms: f64,
    /// Best seed.
    pub seed: u64,
    /// Energies after each step from the best seed.
    pub trace: Vec<f64>,
    /// Final energy of each seed.
    pub energies: Vec<f64>,
    /// Weights of the inputs: lengths of the metric's columns.
    pub relevance: Vec<f64>,
    /// Largest bound of the f32 error.
    pub bound: f64,
}

/// Fitted function without its names.
pub(super) struct Fitted {
    pub(super) sum: KernelSum,
    pub(super) variance: Option<Variance>,
    pub(super) figures: Figures,
    pub(super) report: Report,
    /// Whether the kernels do not reach the next sample.
    pub(super) is_narrow: bool,
    pub(super) warnings: Vec<String>,
}
