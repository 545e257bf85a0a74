//! A function from samples by the fit that options ask for: every sample a centre, or fewer.

use super::error::KernelError;
use super::fewer::{Centres, FewerFit};
use super::fit::Fit;
use super::leave_one_out::LeaveOneOut;
use super::options::Options;
use super::report::FitReport;
use super::samples::Samples;
use crate::scattered::sum::KernelSum;

/// A fit of either kind.
pub enum AnyFit {
    /// Every sample is a centre.
    Every(Box<Fit>),
    /// Fewer centres, by least squares.
    Fewer(Box<FewerFit>),
}

impl AnyFit {
    /// Fits samples.
    ///
    /// # Errors
    /// Those of [`Fit::new`] or [`FewerFit::new`].
    pub fn new(samples: &Samples, options: &Options) -> Result<Self, KernelError> {
        Ok(match options.centres {
            Some(most) if most < samples.sample_len() => {
                Self::Fewer(Box::new(FewerFit::new(samples, options, &Centres::Greedy(most))?))
            }
            _ => Self::Every(Box::new(Fit::new(samples, options)?)),
        })
    }

    /// Returns the function.
    pub fn sum(&self) -> &KernelSum {
        match self {
            Self::Every(fit) => &fit.sum,
            Self::Fewer(fit) => &fit.sum,
        }
    }

    /// Predicts samples by the fit without them.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        match self {
            Self::Every(fit) => fit.leave_one_out(),
            Self::Fewer(fit) => fit.leave_one_out(),
        }
    }

    /// Reports the fit.
    pub fn report(&self, samples: &Samples, options: &Options) -> FitReport {
        match self {
            Self::Every(fit) => FitReport::new(samples, options, fit),
            Self::Fewer(fit) => FitReport::of_fewer(samples, options, fit),
        }
    }
}
