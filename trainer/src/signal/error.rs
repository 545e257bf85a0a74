//! What can be wrong with a signal, with observations, or with what is asked of them.

use crate::bake::BakeError;
use crate::formats::{CsvError, FormatError, JsonError};
use crate::scattered::solver::condition::described;
use std::fmt::{Display, Formatter};
use std::path::PathBuf;

/// Numbers of observations that an error lists at most.
const LISTED: usize = 8;

/// A signal, observations or a picture that nothing can be made of; samples count from 0.
#[derive(Debug, thiserror::Error)]
pub enum SignalError {
    /// The file cannot be read, or is no such file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// It is no JSON of this shape.
    #[error(transparent)]
    Json(#[from] JsonError),
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
    #[error("{what}: expected {expected}, found {}", shown(*found))]
    Number {
        /// What it is.
        what: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// An observation is written wrongly.
    #[error(
        "observation {at}: expected {{\"at\": x, \"value\": y}}, {{\"at\": x, \"derivative\": y}} or \
         {{\"from\": a, \"to\": b, \"average\": y}}, found {found}"
    )]
    Written {
        /// Which.
        at: usize,
        /// What there is.
        found: String,
    },
    /// An observation is not as others determine it, whatever the covariance.
    #[error("{}", contradiction(others, *at, *expected, *found))]
    Contradiction {
        /// Those that determine it; one is of the same thing.
        others: Vec<usize>,
        /// Which.
        at: usize,
        /// What those give.
        expected: f64,
        /// What it says.
        found: f64,
    },
    /// No covariance is called so.
    #[error(
        "there is no covariance \"{found}\"{}: expected {} squared exponential, ornstein-uhlenbeck, matern 3/2 or \
         matern 5/2 with a length, oscillating with a length and a period, as \"matern 3/2:4\" or \
         \"oscillating:8,3\"",
        subject.named(),
        subject.others()
    )]
    Covariance {
        /// What was asked for.
        found: String,
        /// Its use.
        subject: Subject,
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
        "the observations' covariance is ill-conditioned ({}){}: {remedy}",
        described(*rcond),
        told.map_or(String::new(), |told| format!(": {told}"))
    )]
    IllConditioned {
        /// Reciprocal condition.
        rcond: f64,
        /// The first observation that is hardly told from others, if one is found.
        told: Option<Told>,
        /// What to change.
        remedy: &'static str,
    },
    /// The file of a function is too far from it.
    #[error(
        "in single precision the function is off by {deviation:.1e} of its values' range, more than {limit:.1e}: \
         {remedy}, or allow it by --f32-error"
    )]
    Deviation {
        /// The largest deviation that was measured, over the range.
        deviation: f64,
        /// What is allowed.
        limit: f64,
        /// What to change.
        remedy: Remedy,
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

/// What to change where the file of a function is too far from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Inputs, values or both are so large or so small that f32 does not hold their products.
    Units,
    /// Values are far from 0 for their range: a value, and how much f32 rounds it.
    Values(f64, f64),
    /// Inputs are far from 0 for their range: an input, and how much f32 rounds it.
    Inputs(f64, f64),
    /// Inputs are far apart, others near each other: an input, and how much f32 rounds it.
    Apart(f64, f64),
    /// The covariance.
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

/// The use of a covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A signal.
    Signal,
    /// An image.
    Image,
    /// Observations of a function.
    Observations,
}

/// An observation that a covariance hardly tells from those before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Which.
    pub at: usize,
    /// What those before it give.
    pub expected: f64,
    /// What it says.
    pub found: f64,
}

impl Subject {
    /// Names the use after an unknown covariance; a signal needs no name.
    const fn named(self) -> &'static str {
        match self {
            Self::Signal => "",
            Self::Image => " for an image",
            Self::Observations => " for observations",
        }
    }

    /// Lists the choices beside the families.
    const fn others(self) -> &'static str {
        match self {
            Self::Signal => "auto, estimated, a table (.csv), or",
            Self::Image => "auto, a table (.csv), or",
            Self::Observations => "auto, or",
        }
    }
}

impl Display for Told {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { at, expected, found } = *self;
        write!(
            f,
            "it hardly tells observation {at} from those before it, which give {expected:.6} where it says {found:.6}"
        )
    }
}

impl From<CsvError> for SignalError {
    fn from(error: CsvError) -> Self {
        Self::Format(error.into())
    }
}

/// Writes a number, a very large or small one by its power of 10.
fn shown(number: f64) -> String {
    let is_usual = number == 0.0 || (1e-6..1e15).contains(&number.abs());
    if is_usual { format!("{number}") } else { format!("{number:e}") }
}

/// Says that an observation contradicts others.
fn contradiction(others: &[usize], at: usize, expected: f64, found: f64) -> String {
    let remedy = "leave one out, or give a noise";
    let [first] = others else {
        // Sums carry the rounding of f64.
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

/// Lists numbers of observations, the first few of many.
fn listed(of: &[usize]) -> String {
    let first: Vec<String> = of.iter().take(LISTED).map(usize::to_string).collect();
    let first = first.join(", ");
    match of.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first}, {more} more"),
    }
}

/// Refuses a number that is not finite and above 0.
pub(super) fn check_positive(what: &'static str, found: f64) -> Result<(), SignalError> {
    let expected = "a finite number above 0";
    let sound = found > 0.0 && found.is_finite();
    if sound { Ok(()) } else { Err(SignalError::Number { what, expected, found }) }
}
