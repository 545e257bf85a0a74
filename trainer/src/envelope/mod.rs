//! Enveloping: skins that follow a skeleton (S3, METHOD §1).
//!
//! | folder | content |
//! |---|---|
//! | [`lbs`] | poses and trajectories, LBS, prior weights: the input of every fit |
//! | [`folds`] | folds: groups of frames that validation leaves out together |
//! | [`clean`] | finds frames whose mesh does not belong to the pose |
//! | [`helpers`], [`s3`] | the two predictors: each fits a [`model`] |
//! | [`correction`] | kernel maps, which correct the helpers |
//! | [`choose`] | chooses predictor and number of helpers, within `--budget` |
//! | [`model`] | the model in f64: fitted, baked, evaluated, and loaded from a file |
//! | [`oracle`] | evaluates the model in f64, stage by stage; the runtime is tested against it |
//! | `bake` | writes the model's sections |
//! | [`normals`] | tangent coefficients of a skin, which correct its normals |
//! | [`levels`] | further meshes that follow the same palette |

mod bake;
pub mod choose;
pub mod clean;
pub mod correction;
mod error;
pub mod fitted;
pub mod folds;
pub mod helpers;
pub mod lbs;
pub mod levels;
pub mod model;
pub mod normals;
mod options;
pub mod oracle;
pub mod posed;
pub mod s3;
mod train;

pub use choose::Trained;
pub(crate) use error::COARSE;
pub use error::{FitError, TrainError};
pub use options::{FileSkins, Options, Predict};
pub use train::{train, train_on};
