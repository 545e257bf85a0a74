//! Reasons why there is no fit, for code that tries another one.

use crate::Error;
use crate::regression::function::is_scale_invariant;
use sinew_runtime::kernel::Kernel;
use std::fmt::{Display, Formatter};

/// Reason for a refusal that another width or another kernel may not have: the cause of an [`Error`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Refusal {
    /// Rounding errors would determine the function.
    IllConditioned {
        /// Reciprocal condition of the system.
        rcond: f64,
        /// Largest residual of the equations, over the range of the values; 0 for least squares.
        missed: f64,
    },
    /// The file deviates too far from the function, because the kernels are too wide or too smooth.
    Deviation {
        /// Largest measured deviation, over the range.
        deviation: f64,
        /// Largest allowed deviation.
        limit: f64,
        /// Kernel of the fit.
        kernel: Kernel,
    },
}

impl Refusal {
    /// Returns the reason for an error; `None` if another width or another kernel does not help.
    pub(crate) fn of(error: &Error) -> Option<Self> {
        error.cause()?.downcast_ref().copied()
    }

    /// Makes the error, with advice.
    ///
    /// - `near`: two samples that are much nearer than others; used for an ill-conditioned fit only.
    /// - `other`: options that fit.
    pub(crate) fn advised(self, near: Option<String>, other: Option<String>) -> Error {
        match self {
            Self::IllConditioned { rcond, missed } => {
                let samples = match missed > 0.0 {
                    true if missed.is_finite() => {
                        format!(", samples missed by {missed:.1e} of their range")
                    }
                    true => ", numbers beyond f64".to_owned(),
                    false => String::new(),
                };
                let rcond = described(rcond);
                let near = near.map(|near| format!("; {near}: take one of them away"));
                let other = other.map(|other| format!("; {other} fits"));
                let advice = near.unwrap_or_default() + &other.unwrap_or_default();
                Error::fit(format!(
                    "the fit is ill-conditioned ({rcond}{samples}): smooth more, take a narrower kernel or fewer \
                     centres{advice}"
                ))
            }
            Self::Deviation { deviation, limit, kernel } => {
                let other =
                    other.map_or(String::new(), |other| format!("{other}, which fits, or "));
                let narrower = match is_scale_invariant(kernel) {
                    true => "",
                    false => "a narrower kernel (a larger epsilon, a shorter length) or ",
                };
                let remedy = format!(
                    "take {other}{narrower}a rougher kernel, smooth more, take fewer centres"
                );
                too_far(deviation, limit, remedy)
            }
        }
    }
}

impl Display for Refusal {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        self.advised(None, None).fmt(to)
    }
}

impl std::error::Error for Refusal {}

impl From<Refusal> for Error {
    fn from(reason: Refusal) -> Self {
        reason.advised(None, None).caused_by(reason)
    }
}

/// Returns the error of a file's deviation above the limit.
///
/// - `remedy`: what to change.
pub(crate) fn too_far(deviation: f64, limit: f64, remedy: impl Display) -> Error {
    Error::fit(format!(
        "in single precision the function is off by {deviation:.1e} of its values' range, more than {limit:.1e}: \
         {remedy}, or allow it by --f32-error"
    ))
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
