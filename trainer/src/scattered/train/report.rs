//! Results and errors of a training.

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

/// Reasons why a problem cannot be fitted; rows count from 0.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// A site is unusable.
    #[error("{place}: {error}")]
    Site {
        /// Row or line of the site.
        place: String,
        /// Reason.
        error: EvaluationError,
    },
    /// A value is unusable.
    #[error("{place}, output \"{output}\": {error}")]
    Value {
        /// Row or line of the value.
        place: String,
        /// Name of the output.
        output: String,
        /// Reason.
        error: RotationError,
    },
    /// Samples of one site have different values.
    #[error(
        "{rows} have {how} and different values: take their mean (\"average\": true or --average), smooth \
         (--smoothing auto), or take one of them away"
    )]
    Conflict {
        /// Rows or lines of the samples.
        rows: String,
        /// Distance of the sites, in words.
        how: String,
    },
    /// Rounding errors would determine the function.
    #[error("{error}{advice}")]
    IllConditioned {
        /// Error of the fit.
        error: KernelError,
        /// Samples that cause the error, and options that fit.
        advice: String,
    },
    /// The neutral sample does not exist.
    #[error("the neutral sample is row {row}, of {samples}")]
    Neutral {
        /// Row of the neutral sample.
        row: usize,
        /// Number of samples.
        samples: usize,
    },
    /// The name of the kernel is unknown.
    #[error("\"{found}\" is no kernel: expected one of {expected}")]
    KernelName {
        /// Name that was given.
        found: String,
        /// Known names.
        expected: String,
    },
    /// There is no Wendland kernel for this number of inputs.
    #[error("there is no Wendland kernel for {inputs} features: take another")]
    Wendland {
        /// Number of features.
        inputs: usize,
    },
    /// Two options exclude each other.
    #[error("{0}")]
    Options(&'static str),
    /// The numbers of groups and samples differ.
    #[error("expected a group for each of {samples} samples, found {found}")]
    Groups {
        /// Number of samples.
        samples: usize,
        /// Number of groups.
        found: usize,
    },
    /// The numbers of smoothings and samples differ.
    #[error("expected a smoothing for each of {samples} samples, found {found}")]
    Smoothings {
        /// Number of samples.
        samples: usize,
        /// Number of smoothings.
        found: usize,
    },
    /// A smoothing is negative or not finite.
    #[error("the smoothing of row {row} is {found}, expected a finite number that is not negative")]
    Smoothing {
        /// Row of the smoothing.
        row: usize,
        /// Value of the smoothing.
        found: f64,
    },
    /// The limit of the deviation is not finite or not above 0.
    #[error("the f32 error is {0}, expected a finite number above 0: a share of the values' range")]
    F32Error(f64),
    /// A degree is below -1.
    #[error("the degree is {0}, expected -1 (no polynomial) or more")]
    Degree(i32),
    /// The solver refuses the samples.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// SciPy would refuse the samples.
    #[error(transparent)]
    Scipy(#[from] ScipyError),
    /// S2's solver has no result.
    #[error(transparent)]
    Published(#[from] PublishedError),
    /// Learning is impossible.
    #[error(transparent)]
    Learn(#[from] HyperError),
    /// The fit has no variance.
    #[error(
        "only a fit with every sample a centre has a variance: leave out `centres`, `learn` and `mode`"
    )]
    NoVariance,
}
