//! Enveloping: how a skin follows its skeleton (S3, METHOD §1).
//!
//! | folder | what it does |
//! |---|---|
//! | [`skin`] | what every fit reads: poses, trajectories, LBS, weights |
//! | [`folds`] | which frames are left out together |
//! | [`rotational`], [`helpers`] | the two predictors: functions from that to a [`model`] |
//! | [`correction`] | what kernel maps add to either |
//! | [`choose`], `budget` | which predictor and how many proxies, within `--budget` |
//! | [`model`] | the one model in f64: fitted, baked, evaluated, and read back from a file |
//! | [`oracle`] | its evaluation, stage by stage: what the runtime is held to |
//! | `bake` | how a file holds it |
//! | [`normals`] | tangent coefficients of a skin, by which its normals are right |
//! | [`levels`] | further meshes that follow the same palette |
//! | [`check`], [`evaluate`], [`report`], [`export`], [`demo`] | the commands' work |

pub mod alike;
mod bake;
mod budget;
mod candidate;
pub mod check;
pub mod choose;
pub mod correction;
mod counts;
pub mod demo;
mod error;
pub mod evaluate;
pub mod export;
pub mod fitted;
pub mod folds;
mod forecast;
pub mod helpers;
pub mod levels;
pub mod model;
pub mod normals;
mod options;
pub mod oracle;
pub mod posed;
pub mod predicted;
pub mod report;
pub mod rotational;
mod settings;
pub mod skin;
mod train;
pub mod training_report;

pub use choose::Trained;
pub use error::{FitError, TrainError};
pub use options::{FileSkins, Options, Predict};
pub use settings::Settings;
pub use train::{train, train_on};
