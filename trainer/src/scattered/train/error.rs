//! Why a problem cannot be fitted.

use crate::regression::rotations::RotationError;
use crate::scattered::compat::published::PublishedError;
use crate::scattered::compat::scipy::ScipyError;
use crate::scattered::hyper::HyperError;
use crate::scattered::model::EvaluationError;
use crate::scattered::solver::error::KernelError;

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
