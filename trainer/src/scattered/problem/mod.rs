//! A problem as a person writes it: samples of a function from named inputs to named outputs, as JSON, CSV
//! or `.npz`.

mod csv;
mod definition;
mod error;
mod json;
mod kinds;
mod npz;
mod options;
mod read;

pub use definition::Problem;
pub use error::ProblemError;
pub(super) use json::rows;
pub use options::{Learn, LearnMethod, LearnMetric, Mode, ProblemOptions, Smoothing};
pub use read::{read, read_queries};
