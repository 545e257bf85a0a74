//! The training, from examples to a file; what is tried and taken is in `choose`.

use super::choose::{self, Trained};
use super::error::{COARSE, FitError, TrainError};
use super::options::{Options, Predict};
use crate::bake::BakeError;
use crate::envelope::clean::Sound;
use crate::examples::Examples;
use crate::progress::Progress;

/// Fits an envelope to the training frames of the examples and bakes it. Frames whose meshes do not belong to their poses
/// are left out, and stand in the report.
///
/// The same examples give the same bytes for any number of threads.
///
/// # Errors
/// Every [`TrainError`].
pub fn train(
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    train_on(Sound::new(examples, progress)?, options, progress)
}

/// Trains as [`train`] does, on frames that were judged before.
///
/// # Errors
/// Every [`TrainError`].
pub fn train_on(
    sound: Sound<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    let examples = sound.training.examples;
    if let Some(error) = FitError::too_far(examples, COARSE.1) {
        return Err(error.into());
    }
    let poses = &sound.training.poses;
    if poses.are_one() {
        return Err(FitError::OnePose { found: poses.len() }.into());
    }
    let left_out = sound.left_out().to_vec();
    let mut training = sound.weighted(progress)?;
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
