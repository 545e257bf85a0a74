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

pub use choose::Trained;
pub(crate) use error::COARSE;
pub use error::{FitError, TrainError};
pub use options::{FileSkins, Options, Predict};

use crate::bake::BakeError;
use crate::examples::Examples;
use crate::progress::Progress;
use clean::Inliers;

/// Fits an envelope to the training frames of the examples and bakes it. Outlier frames are left out and reported.
///
/// Equal examples give equal bytes for any number of threads.
///
/// # Errors
/// Every [`TrainError`].
pub fn train(
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    train_on(Inliers::new(examples, progress)?, options, progress)
}

/// Trains like [`train`], with the outliers already found.
///
/// # Errors
/// Every [`TrainError`].
pub fn train_on(
    inliers: Inliers<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    let examples = inliers.training.examples;
    if let Some(error) = FitError::too_far(examples, COARSE.1) {
        return Err(error.into());
    }
    let poses = &inliers.training.poses;
    if poses.are_equal() {
        return Err(FitError::OnePose { found: poses.len() }.into());
    }
    let left_out = inliers.left_out().to_vec();
    let mut training = inliers.weighted(progress)?;
    training.settings = options.settings.clone();
    if options.predictor == Predict::Published {
        training.lbs = training.free_lbs();
    }
    let trained = choose::choose(&training, options, progress);
    let mut trained = trained.map_err(|error| match error {
        TrainError::Bake(BakeError::Refused(_)) => {
            FitError::too_far(examples, COARSE.0).map_or(error, TrainError::Fit)
        }
        _ => error,
    })?;
    trained.report.left_out = left_out;
    Ok(trained)
}
