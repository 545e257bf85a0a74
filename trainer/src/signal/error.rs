//! What can be wrong with a signal, with observations, or with what is asked of them.

use crate::bake::BakeError;
use crate::formats::{CsvError, FormatError};
use std::path::PathBuf;

/// A signal, observations or a picture that nothing can be made of; samples count from 0.
#[derive(Debug, thiserror::Error)]
pub enum SignalError {
    /// The file cannot be read, or is no such file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// It is no JSON of this shape.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// It cannot be written to a model file.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A picture cannot be read.
    #[error("{}: {what}", file.display())]
    Picture {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// There is nothing to learn from.
    #[error("there are no observations")]
    Empty,
    /// An observation is none.
    #[error("observation {at}: {what}")]
    Observation {
        /// Which.
        at: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// A signal has fewer samples than a window.
    #[error("{found} samples are fewer than a window's {least}: take fewer taps")]
    TooShort {
        /// Samples of the signal.
        found: usize,
        /// Samples of a window.
        least: usize,
    },
    /// Boxes do not fill a side or a signal.
    #[error("{what}: expected a multiple of {factor}, found {found}")]
    Multiple {
        /// What is to be filled.
        what: &'static str,
        /// Its length.
        found: usize,
        /// That of a box.
        factor: usize,
    },
    /// A number is out of its range.
    #[error("{what}: expected {expected}, found {found}")]
    Number {
        /// What it is.
        what: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// No covariance is called so.
    #[error(
        "there is no covariance \"{found}\": expected auto, estimated, a table (.csv), or squared exponential, \
         ornstein-uhlenbeck, matern 3/2 or matern 5/2 with a length, oscillating with a length and a period, \
         as \"matern 3/2:4\" or \"oscillating:8,3\""
    )]
    Covariance {
        /// What was asked for.
        found: String,
    },
    /// A derivative is asked for of functions that have none.
    #[error("observation {at}: functions of covariance {covariance} have no derivative")]
    Rough {
        /// The observation.
        at: usize,
        /// The covariance.
        covariance: &'static str,
    },
    /// Observations leave the mean open.
    #[error("these observations do not tell a {mean} mean: take a simpler one, or observe values")]
    Mean {
        /// The mean.
        mean: &'static str,
    },
    /// Rounding decides what the function is.
    #[error(
        "the observations' covariance is ill-conditioned ({rcond:.0e}): take a shorter length, a rougher \
         covariance, or a noise"
    )]
    IllConditioned {
        /// Reciprocal condition.
        rcond: f64,
    },
    /// A matrix is not positive definite.
    #[error("{what} is not positive definite")]
    Indefinite {
        /// The matrix.
        what: &'static str,
    },
    /// No kernel part is the function.
    #[error("no part kernel holds {what}: it can hold {can}")]
    NoKernel {
        /// What it cannot hold.
        what: String,
        /// What it can.
        can: &'static str,
    },
}

impl From<CsvError> for SignalError {
    fn from(error: CsvError) -> Self {
        Self::Format(error.into())
    }
}

/// Refuses a number that is not finite and above 0.
pub(super) fn check_positive(what: &'static str, found: f64) -> Result<(), SignalError> {
    let expected = "a finite number above 0";
    let sound = found > 0.0 && found.is_finite();
    if sound { Ok(()) } else { Err(SignalError::Number { what, expected, found }) }
}
