//! Signals and functions as random processes: the likeliest function given observations, and finer signals and
//! pictures (S0 §1 and §4, METHOD §4).
//!
//! | file | contents |
//! |---|---|
//! | [`covariance`], [`table`] | covariances: families with parameters, and tables; their estimates and CSV files |
//! | `lags` | a table of covariances at even distances, made positive definite |
//! | [`functional`] | what an observation measures: a value, a derivative, a box average |
//! | [`kriging`], [`solved`] | the likeliest function, and the linear systems behind it |
//! | [`choose`] | chooses the covariance that predicts a signal best |
//! | [`grid`], [`model`] | filters for regular grids: taps by phase; their accuracy and their part of a file |
//! | [`image`] | finer pictures: columns, then rows |
//! | [`observations`] | observations in JSON, and their function as a kernel part |
//! | [`sum`] | a function as a sum of kernels, and the deviation of its file |
//! | `faults` | errors that several files make |
//! | `repeated` | finds observations that earlier ones determine |
//! | [`plot`] | a picture of a curve with its error band |

pub mod choose;
pub mod covariance;
mod faults;
pub mod functional;
pub mod grid;
pub mod image;
pub mod kriging;
mod lags;
pub mod model;
pub mod observations;
pub mod plot;
mod repeated;
pub mod solved;
pub mod sum;
pub mod table;
