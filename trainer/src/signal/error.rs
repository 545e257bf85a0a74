//! What can be wrong with a signal, with observations, or with what is asked of them.

use crate::bake::BakeError;
use crate::formats::{CsvError, FormatError, JsonError};
use crate::kernel::scattered::condition::described;
use crate::kernel::scattered::error::KernelError;
use std::fmt::{Display, Formatter};
use std::path::PathBuf;

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
    #[error("{what}: expected {expected}, found {found}")]
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
    /// Two observations of one thing differ.
    #[error(
        "observations {first} and {second} contradict each other: they are of one thing and say {one} and {other}; \
         leave one out, or give a noise"
    )]
    Contradiction {
        /// The earlier one.
        first: usize,
        /// The later one.
        second: usize,
        /// What the earlier one says.
        one: f64,
        /// What the later one says.
        other: f64,
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
        "the observations' covariance is ill-conditioned ({}){}: take a shorter length, a rougher covariance, or a \
         noise",
        described(*rcond),
        told.map_or(String::new(), |told| format!(": {told}"))
    )]
    IllConditioned {
        /// Reciprocal condition.
        rcond: f64,
        /// The first observation that others tell, if one is found.
        told: Option<Told>,
    },
    /// A matrix is not positive definite.
    #[error("{what} is not positive definite")]
    Indefinite {
        /// The matrix.
        what: &'static str,
    },
    /// Kernels do not make the function, or its file misses it.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// No kernel part is the function.
    #[error("no part kernel holds {what}: it can hold {can}")]
    NoKernel {
        /// What it cannot hold.
        what: String,
        /// What it can.
        can: &'static str,
    },
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

/// An observation that those before it tell.
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
            "those before observation {at} leave it no choice, they give {expected:.6} and it says {found:.6}"
        )
    }
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
