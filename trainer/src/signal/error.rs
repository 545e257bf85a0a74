//! Errors in signals, observations and requests.

use crate::bake::BakeError;
use crate::formats::{CsvError, FormatError, JsonError};
use crate::scattered::solver::error::described;
use std::fmt::{Display, Formatter};
use std::path::PathBuf;

/// Most observation numbers that a message lists.
const LISTED: usize = 8;

/// An unusable signal, observation set, picture or request; samples and observations count from 0.
#[derive(Debug, thiserror::Error)]
pub enum SignalError {
    /// The file cannot be read or has the wrong format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The JSON does not have the expected fields.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// The result does not fit a model file.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A picture cannot be read.
    #[error("{}: {what}", file.display())]
    Picture {
        /// The file.
        file: PathBuf,
        /// The problem.
        what: String,
    },
    /// There are no observations.
    #[error("there are no observations")]
    Empty,
    /// An observation is invalid.
    #[error("observation {at}: {what}")]
    Observation {
        /// Observation number.
        at: usize,
        /// The problem.
        what: &'static str,
    },
    /// A signal has fewer samples than a window.
    #[error("{found} samples are fewer than a window's {least}: take fewer taps")]
    TooShort {
        /// Samples in the signal.
        found: usize,
        /// Samples in a window.
        least: usize,
    },
    /// A length is not a multiple of the box size.
    #[error("{what}: expected a multiple of {factor}, found {found}")]
    Multiple {
        /// The side or signal.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Length of a box.
        factor: usize,
    },
    /// A number is out of its range.
    #[error("{what}: expected {expected}, found {}", shown(*found))]
    Number {
        /// The number's name.
        what: &'static str,
        /// Allowed values.
        expected: &'static str,
        /// The number.
        found: f64,
    },
    /// An observation has the wrong JSON fields.
    #[error(
        "observation {at}: expected {{\"at\": x, \"value\": y}}, {{\"at\": x, \"derivative\": y}} or \
         {{\"from\": a, \"to\": b, \"average\": y}}, found {found}"
    )]
    Written {
        /// Observation number.
        at: usize,
        /// The observation as written.
        found: String,
    },
    /// An observation contradicts the value that other observations imply, for any covariance.
    #[error("{}", contradiction(others, *at, *expected, *found))]
    Contradiction {
        /// Observations that imply the value; a single entry measures the same quantity.
        others: Vec<usize>,
        /// Observation number.
        at: usize,
        /// Value implied by the others.
        expected: f64,
        /// Value of the observation.
        found: f64,
    },
    /// The covariance is unknown.
    #[error(
        "there is no covariance \"{found}\"{}: expected {} squared exponential, ornstein-uhlenbeck, matern 3/2 or \
         matern 5/2 with a length, oscillating with a length and a period, as \"matern 3/2:4\" or \
         \"oscillating:8,3\"",
        subject.named(),
        subject.others()
    )]
    Covariance {
        /// The covariance as written.
        found: String,
        /// Use of the covariance.
        subject: Subject,
    },
    /// A derivative is observed, but the covariance has no derivative.
    #[error("observation {at}: functions of covariance {covariance} have no derivative")]
    Rough {
        /// Observation number.
        at: usize,
        /// Name of the covariance.
        covariance: &'static str,
    },
    /// The observations do not determine the mean.
    #[error(
        "these observations do not determine a {mean} mean: take a simpler one, or observe values"
    )]
    Mean {
        /// Name of the mean.
        mean: &'static str,
    },
    /// Rounding errors dominate the solution.
    #[error(
        "the observations' covariance is ill-conditioned ({}){}: {remedy}",
        described(*rcond),
        redundant.map_or(String::new(), |redundant| format!(": {redundant}"))
    )]
    IllConditioned {
        /// Reciprocal condition.
        rcond: f64,
        /// The first observation that is nearly redundant, if found.
        redundant: Option<Redundant>,
        /// Suggested change.
        remedy: &'static str,
    },
    /// The baked function deviates too much from the exact function.
    #[error(
        "in single precision the function is off by {deviation:.1e} of its values' range, more than {limit:.1e}: \
         {remedy}, or allow it by --f32-error"
    )]
    Deviation {
        /// Largest measured deviation, relative to the range of values.
        deviation: f64,
        /// Allowed deviation.
        limit: f64,
        /// Suggested change.
        remedy: Remedy,
    },
    /// A matrix is not positive definite.
    #[error("{what} is not positive definite")]
    Indefinite {
        /// Name of the matrix.
        what: &'static str,
    },
    /// A kernel part cannot represent the function.
    #[error("no part kernel holds {what}: it can hold {can}")]
    NoKernel {
        /// The unsupported feature.
        what: String,
        /// Supported features.
        can: &'static str,
    },
}

/// Suggested change if the baked function deviates too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Change the units: f32 overflows or underflows.
    Units,
    /// Subtract an offset from the values. Fields: a value and its f32 rounding error.
    Values(f64, f64),
    /// Subtract an offset from the inputs. Fields: an input and its f32 rounding error.
    Inputs(f64, f64),
    /// Split the function: some inputs are close together and others far away. Fields: an input and its f32 rounding
    /// error.
    Apart(f64, f64),
    /// Change the covariance, as the text says.
    Covariance(&'static str),
}

impl Display for Remedy {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (what, at, by, then) = match *self {
            Self::Units => {
                return f.write_str("give inputs and values in units in which they are near 1");
            }
            Self::Covariance(change) => return f.write_str(change),
            Self::Values(at, by) => ("values", at, by, "take an offset off the values"),
            Self::Inputs(at, by) => ("inputs", at, by, "take an offset off the inputs"),
            Self::Apart(at, by) => {
                ("inputs", at, by, "fit inputs so far apart as functions of their own")
            }
        };
        write!(f, "{what} near {at} are rounded by {by:.1e}: {then}")
    }
}

/// Use of a covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A signal.
    Signal,
    /// An image.
    Image,
    /// Observations of a function.
    Observations,
}

/// An observation that earlier ones nearly determine under the covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Redundant {
    /// Observation number.
    pub at: usize,
    /// Prediction from the earlier observations.
    pub expected: f64,
    /// Value of the observation.
    pub found: f64,
}

impl Subject {
    /// Returns the phrase that names the use in the message about an unknown covariance.
    const fn named(self) -> &'static str {
        match self {
            Self::Signal => "",
            Self::Image => " for an image",
            Self::Observations => " for observations",
        }
    }

    /// Lists the alternatives to a family.
    const fn others(self) -> &'static str {
        match self {
            Self::Signal => "auto, estimated, a table (.csv), or",
            Self::Image => "auto, a table (.csv), or",
            Self::Observations => "auto, or",
        }
    }
}

impl Display for Redundant {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { at, expected, found } = *self;
        write!(
            f,
            "observation {at} says {found:.6} where earlier ones nearly determine {expected:.6}"
        )
    }
}

impl From<CsvError> for SignalError {
    fn from(error: CsvError) -> Self {
        Self::Format(error.into())
    }
}

/// Formats a number; very large and very small numbers get an exponent.
fn shown(number: f64) -> String {
    let is_usual = number == 0.0 || (1e-6..1e15).contains(&number.abs());
    if is_usual { format!("{number}") } else { format!("{number:e}") }
}

/// Formats the message about a contradiction.
fn contradiction(others: &[usize], at: usize, expected: f64, found: f64) -> String {
    let remedy = "leave one out, or give a noise";
    let [first] = others else {
        // Sums have f64 rounding errors, so f32 digits are shown.
        let (others, expected) = (listed(others), expected as f32);
        return format!(
            "observation {at} contradicts observations {others}: they give {expected} and it says {found}; {remedy}"
        );
    };
    format!(
        "observations {first} and {at} contradict each other: they are of one thing and say {expected} and {found}; \
         {remedy}"
    )
}

/// Lists observation numbers; counts those after the first few.
fn listed(of: &[usize]) -> String {
    let first: Vec<String> = of.iter().take(LISTED).map(usize::to_string).collect();
    let first = first.join(", ");
    match of.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first}, {more} more"),
    }
}

/// Checks that a number is positive and finite.
///
/// # Errors
/// [`SignalError::Number`].
pub(super) fn check_positive(what: &'static str, found: f64) -> Result<(), SignalError> {
    let expected = "a finite number above 0";
    let sound = found > 0.0 && found.is_finite();
    if sound { Ok(()) } else { Err(SignalError::Number { what, expected, found }) }
}
