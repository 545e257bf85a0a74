//! The training, from examples to a file; what is tried and taken is in `choose`.

use super::choose::{self, Trained};
use super::error::{FitError, TrainError};
use super::options::Options;
use super::predicted;
use crate::examples::{Examples, Split};
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
    let frames = examples.frames_of(Split::Train);
    if frames.windows(2).all(|pair| examples.pose(pair[0]) == examples.pose(pair[1])) {
        return Err(FitError::OnePose { found: frames.len() }.into());
    }
    let (training, left_out) = predicted::sound(examples, progress)?;
    let mut trained = choose::choose(&training, examples, options, progress)?;
    trained.report.left_out = left_out;
    Ok(trained)
}
