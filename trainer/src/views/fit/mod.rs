//! Fits maps to views. Inputs, polynomial and kernel are chosen by leaving views out (METHOD §6).

mod block;
mod examples;
mod map;

pub use block::{Candidate, LeftOutViews};
pub use examples::{Choice, FitOptions, FittedMap, fit, fit_each};
pub use map::{MapOutputs, Shown, given, names_of, weights};
pub(in crate::views) use map::{angles_of, unknown_parameter, with_features};
