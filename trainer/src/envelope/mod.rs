//! Enveloping: how a skin follows its skeleton (S3, METHOD §1).

mod bake;
pub mod blend;
pub mod check;
pub mod choose;
pub mod demo;
mod error;
pub mod evaluate;
pub mod export;
pub mod fitted;
pub mod folds;
pub mod helpers;
pub mod levels;
pub mod model;
pub mod motion;
mod options;
pub mod oracle;
pub mod posed;
pub mod report;
pub mod rotational;
mod rounding;
pub mod targets;
mod train;
pub mod training;
pub mod weights;

pub use choose::Trained;
pub use error::{FitError, TrainError};
pub use options::{Meshes, Options, Predict};
pub use train::train;
