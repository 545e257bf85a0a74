//! Reasons why there is no fit, for code that tries another one.

use crate::Error;
use crate::scattered::deviation::{Deviation, DeviationCause};
use std::fmt::{Display, Formatter};

/// Rounding errors would determine the function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IllConditioned {
    /// Reciprocal condition of the system.
    pub(crate) rcond: f64,
    /// Largest residual of the equations, over the range of the values; 0 for least squares.
    pub(crate) missed: f64,
}

/// Reason why there is no fit.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// Rounding errors would determine the function.
    IllConditioned(IllConditioned),
    /// The deviation of the file from the function is too large.
    Deviation(Deviation),
    /// Another reason.
    Other(Error),
}

impl Refusal {
    /// Returns true if another width or another kernel may fit.
    pub(crate) fn is_caused_by_kernel(&self) -> bool {
        match self {
            Self::IllConditioned(_) => true,
            Self::Deviation(deviation) => matches!(deviation.cause, DeviationCause::Kernel { .. }),
            Self::Other(_) => false,
        }
    }
}

impl Display for IllConditioned {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { rcond, missed } = *self;
        let samples = match missed > 0.0 {
            true if missed.is_finite() => {
                format!(", samples missed by {missed:.1e} of their range")
            }
            true => ", numbers beyond f64".to_owned(),
            false => String::new(),
        };
        let rcond = described(rcond);
        write!(
            to,
            "the fit is ill-conditioned ({rcond}{samples}): smooth more, take a narrower kernel or fewer centres"
        )
    }
}

impl From<IllConditioned> for Error {
    fn from(reason: IllConditioned) -> Self {
        Self::fit(reason.to_string())
    }
}

impl From<IllConditioned> for Refusal {
    fn from(reason: IllConditioned) -> Self {
        Self::IllConditioned(reason)
    }
}

impl From<Deviation> for Refusal {
    fn from(reason: Deviation) -> Self {
        Self::Deviation(reason)
    }
}

impl From<Error> for Refusal {
    fn from(reason: Error) -> Self {
        Self::Other(reason)
    }
}

impl From<Refusal> for Error {
    fn from(reason: Refusal) -> Self {
        match reason {
            Refusal::IllConditioned(reason) => reason.into(),
            Refusal::Deviation(reason) => reason.into(),
            Refusal::Other(error) => error,
        }
    }
}

/// Formats a reciprocal condition for error messages. Below f64's precision no digit is known.
pub(crate) fn described(rcond: f64) -> String {
    if rcond < f64::EPSILON {
        format!("reciprocal condition below {:.0e}", f64::EPSILON)
    } else {
        format!("reciprocal condition {rcond:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::described;

    #[test]
    fn conditions_below_f64_precision_are_named_so() {
        assert_eq!(described(3.4e-9), "reciprocal condition 3.4e-9");
        for rcond in [0.0, 1e-17] {
            assert_eq!(described(rcond), "reciprocal condition below 2e-16");
        }
    }
}
