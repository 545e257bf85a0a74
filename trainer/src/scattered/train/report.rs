//! What a training says of itself.

use crate::scattered::model::KernelModel;
use crate::scattered::solver::report::FitReport;
use serde::Serialize;

/// A function, and how it was found.
pub struct Trained {
    /// The function.
    pub model: KernelModel,
    /// How it was fitted.
    pub report: Report,
    /// By how much its file is off at most, over the range of the value: measured at the samples and at 1,000
    /// queries between them.
    pub deviation: f64,
    /// What should be known of it.
    pub warnings: Vec<String>,
}

/// How a function was fitted.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// By METHOD §2.
    Fit(Box<FitReport>),
    /// With learned centres.
    Learned(LearnReport),
    /// By the rules of a named mode: nothing but its condition.
    Mode {
        /// Condition of what was solved: its reciprocal.
        rcond: f64,
        /// RMS of what is left of the values at the samples.
        residual_rms: f64,
    },
}

/// How centres and metric were learned.
#[derive(Clone, Debug, Serialize)]
pub struct LearnReport {
    /// The energy that is left.
    pub energy: f64,
    /// RMS of what is left of the values at the samples.
    pub residual_rms: f64,
    /// The seed that was kept.
    pub seed: u64,
    /// Energies after each step of it.
    pub trace: Vec<f64>,
    /// Energies that each seed ended with.
    pub energies: Vec<f64>,
    /// Weights of the inputs: lengths of the metric's columns.
    pub relevance: Vec<f64>,
    /// The largest bound of what f32 arithmetic may be off by.
    pub bound: f64,
}
