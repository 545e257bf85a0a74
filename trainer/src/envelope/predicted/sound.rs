//! A training on the frames that belong to their poses.

use super::broken::{Broken, broken};
use crate::envelope::error::FitError;
use crate::envelope::skin::training::Training;
use crate::examples::{Examples, Split};
use crate::progress::Progress;
use serde::Serialize;

/// How often frames are looked at anew, as LBS is fitted without those that were found.
const ROUNDS: usize = 3;

/// A training frame that is left out, for its mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// The frame.
    pub frame: usize,
    /// How many times its error is what is usual.
    pub times: f64,
}

/// Gathers the training frames whose meshes belong to their poses, as often as each counts, and lists the others, the
/// worst first.
///
/// # Errors
/// Those of [`Training::new`].
pub fn sound(
    examples: &Examples,
    progress: &dyn Progress,
) -> Result<(Training, Vec<LeftOut>), FitError> {
    let mut frames = examples.frames_of(Split::Train);
    let mut training = Training::of(examples, &frames, progress)?;
    let mut left_out = Vec::new();
    for _ in 0..ROUNDS {
        progress.step("frames", 1);
        let found = broken(&training);
        if found.is_empty() {
            break;
        }
        left_out.extend(
            found.iter().map(|&Broken { pose, times }| LeftOut { frame: frames[pose], times }),
        );
        frames.retain(|frame| left_out.iter().all(|out| out.frame != *frame));
        training = Training::of(examples, &frames, progress)?;
    }
    // Of frames that stand there twice each would vouch for the other.
    let repeated = examples.repeated(&frames);
    if repeated.len() > frames.len() {
        training = Training::of(examples, &repeated, progress)?;
    }
    Ok((training, left_out))
}
