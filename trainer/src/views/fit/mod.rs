//! From views to a map: inputs, polynomial and kernel chosen by leaving views out (METHOD §6).

mod block;
mod candidate;
mod error;
mod examples;
mod inputs;
mod outputs;
mod terms;

pub use block::LeftOutViews;
pub use candidate::Candidate;
pub use error::FitError;
pub use examples::{Choice, FitOptions, FittedMap, fit, fit_each};
pub use inputs::{given, names_of};
pub use outputs::{MapOutputs, Shown};
