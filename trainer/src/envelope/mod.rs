//! Enveloping: how a skin follows its skeleton (S3, METHOD §1).

mod bake;
pub mod check;
pub mod choose;
pub mod correction;
pub mod demo;
mod error;
pub mod evaluate;
pub mod export;
pub mod fitted;
pub mod helpers;
pub mod levels;
pub mod model;
mod options;
pub mod oracle;
pub mod posed;
pub mod report;
pub mod rotational;
pub mod skin;
mod train;

pub use choose::Trained;
pub use error::{FitError, TrainError};
pub use options::{FileSkins, Options, Predict};
pub use train::train;
