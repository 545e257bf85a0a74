//! What a training says of itself.
//! What every way of fitting gives.
//! Why a problem cannot be fitted.

use crate::regression::rotations::RotationError;
use crate::scattered::compat::published::PublishedError;
use crate::scattered::compat::scipy::ScipyError;
use crate::scattered::hyper::HyperError;
use crate::scattered::model::{EvaluationError, Figures, KernelModel};
use crate::scattered::solver::error::KernelError;
use crate::scattered::solver::leave_one_out::Variance;
use crate::scattered::solver::report::FitReport;
use crate::scattered::sum::KernelSum;
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

/// A function without its names.
pub(super) struct Fitted {
    pub(super) sum: KernelSum,
    pub(super) variance: Option<Variance>,
    pub(super) figures: Figures,
    pub(super) report: Report,
    /// Whether kernels do not reach the next sample.
    pub(super) is_narrow: bool,
    pub(super) warnings: Vec<String>,
}

/// A problem that cannot be fitted; rows count from 0.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// A site cannot be taken.
    #[error("{place}: {error}")]
    Site {
        /// Its row or line.
        place: String,
        /// Why.
        error: EvaluationError,
    },
    /// A value cannot be taken.
    #[error("{place}, output \"{output}\": {error}")]
    Value {
        /// Its row or line.
        place: String,
        /// The output.
        output: String,
        /// Why.
        error: RotationError,
    },
    /// Samples of one site have different values.
    #[error(
        "{rows} have {how} and different values: take their mean (\"average\": true or --average), smooth \
         (--smoothing auto), or take one of them away"
    )]
    Conflict {
        /// Their rows or lines.
        rows: String,
        /// How near their sites are.
        how: String,
    },
    /// Rounding decides what the function is.
    #[error("{error}{advice}")]
    IllConditioned {
        /// What was refused.
        error: KernelError,
        /// What comes of these samples, and what fits them.
        advice: String,
    },
    /// The neutral sample is not there.
    #[error("the neutral sample is row {row}, of {samples}")]
    Neutral {
        /// The row.
        row: usize,
        /// Samples.
        samples: usize,
    },
    /// A kernel's name is unknown.
    #[error("\"{found}\" is no kernel: expected one of {expected}")]
    KernelName {
        /// The name.
        found: String,
        /// Those that there are.
        expected: String,
    },
    /// There is no Wendland kernel for so many inputs.
    #[error("there is no Wendland kernel for {inputs} features: take another")]
    Wendland {
        /// Features.
        inputs: usize,
    },
    /// An option does not go with another.
    #[error("{0}")]
    Options(&'static str),
    /// Groups are not as many as samples.
    #[error("expected a group for each of {samples} samples, found {found}")]
    Groups {
        /// Samples.
        samples: usize,
        /// Groups.
        found: usize,
    },
    /// Smoothings are not as many as samples.
    #[error("expected a smoothing for each of {samples} samples, found {found}")]
    Smoothings {
        /// Samples.
        samples: usize,
        /// Smoothings.
        found: usize,
    },
    /// A smoothing is negative or not finite.
    #[error("the smoothing of row {row} is {found}, expected a finite number that is not negative")]
    Smoothing {
        /// Its row.
        row: usize,
        /// What it is.
        found: f64,
    },
    /// A share that was asked for is none.
    #[error("the f32 error is {0}, expected a finite number above 0: a share of the values' range")]
    F32Error(f64),
    /// A degree is below -1.
    #[error("the degree is {0}, expected -1 (no polynomial) or more")]
    Degree(i32),
    /// Scattered data gives no function.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// SciPy would refuse it.
    #[error(transparent)]
    Scipy(#[from] ScipyError),
    /// S2's solver has no result.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// Nothing can be learned.
    #[error(transparent)]
    Learn(#[from] HyperError),
    /// The fit has no variance.
    #[error(
        "only a fit with every sample a centre has a variance: leave out `centres`, `learn` and `mode`"
    )]
    NoVariance,
}
