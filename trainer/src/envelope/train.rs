//! The training, from examples to a file; what is tried and taken is in `choose`.

use super::choose::{self, Trained};
use super::error::{FitError, TrainError};
use super::options::Options;
use crate::envelope::skin::training::Training;
use crate::examples::{Examples, Split};
use crate::progress::Progress;

/// Fits an envelope to the training frames of the examples and bakes it.
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
    let training = Training::new(examples, progress)?;
    choose::choose(&training, examples, options, progress)
}
