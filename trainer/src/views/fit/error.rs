//! Why views give no map.

use crate::scattered::model::EvaluationError;
use crate::scattered::solver::error::KernelError;

/// Views that no map was fitted to; views count from 0.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// Parameters of a view cannot be taken.
    #[error("train view {view}: {error}")]
    Site {
        /// The view.
        view: usize,
        /// Why.
        error: EvaluationError,
    },
    /// Parameters cannot be taken.
    #[error(transparent)]
    Given(#[from] EvaluationError),
    /// A parameter has no value.
    #[error("parameter \"{0}\" is missing")]
    Missing(String),
    /// A name is no parameter's.
    #[error("\"{found}\" is no parameter: expected {expected}")]
    Unknown {
        /// The name.
        found: String,
        /// Those that there are.
        expected: String,
    },
    /// The parameters of all views cannot be measured.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// Two views have the same parameters and different points.
    #[error("train views {first} and {second} have the same parameters")]
    Same {
        /// The earlier view.
        first: usize,
        /// The later one.
        second: usize,
    },
    /// Nothing could be solved.
    #[error("no polynomial and no kernel can be fitted to {views} views")]
    None {
        /// Views.
        views: usize,
    },
}
