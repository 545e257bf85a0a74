//! From a problem to a function with names: by METHOD §2, by SciPy's rules, by S2's, or with learned
//! centres.

mod error;
mod fitted;
mod learned;
mod matrices;
mod modes;
mod problem;
mod report;
mod solved;

pub use error::TrainError;
pub use problem::train;
pub use report::{LearnReport, Report, Trained};
