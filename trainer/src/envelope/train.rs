//! The training, from examples to a file; what is tried and taken is in `choose`.

use super::choose::{self, Trained};
use super::error::TrainError;
use super::options::Options;
use crate::envelope::skin::training::Training;
use crate::examples::Examples;
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
    let training = Training::new(examples, progress)?;
    choose::choose(&training, examples, options, progress)
}
