//! A training on the frames that belong to their poses.

use super::broken::{Broken, broken};
use crate::envelope::error::FitError;
use crate::envelope::skin::poses::Poses;
use crate::envelope::skin::training::{MIN_POSES, Training};
use crate::examples::{Examples, Split};
use crate::progress::Progress;
use serde::Serialize;

/// How often frames are looked at anew, as LBS is fitted without those that were found.
const ROUNDS: usize = 3;
/// Share of the frames beyond which they are no exceptions, and stay.
const MOST: f64 = 0.25;

/// A training frame whose mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Doubted {
    /// The frame.
    pub frame: usize,
    /// How many times its error is what is usual.
    pub times: f64,
}

/// The training frames whose meshes belong to their poses, and the others.
pub struct Sound {
    /// A training on the frames that belong to their poses, once each, and on those that stay.
    pub training: Training,
    /// The others, the worst of each look first.
    pub doubted: Vec<Doubted>,
    /// Whether they stay in the training, for it would have too few frames, or no motion, without them.
    pub stay: bool,
}

impl Sound {
    /// Looks at the training frames of the examples. Meshes of the scene's own skin all belong to their poses.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn new(examples: &Examples, progress: &dyn Progress) -> Result<Self, FitError> {
        let mut frames = examples.frames_of(Split::Train);
        let training = Training::of(examples, &frames, progress)?;
        let most = (MOST * frames.len() as f64).max(1.0) as usize;
        let most = most.min(frames.len() - MIN_POSES);
        let mut sound = Self { training, doubted: Vec::new(), stay: false };
        if examples.own_skin {
            return Ok(sound);
        }
        for _ in 0..ROUNDS {
            progress.step("frames", 1);
            let found = broken(&sound.training);
            let of = |&Broken { pose, times }: &Broken| Doubted { frame: frames[pose], times };
            let found: Vec<Doubted> = found.iter().map(of).collect();
            if found.is_empty() {
                break;
            }
            sound.doubted.extend(found);
            frames.retain(|frame| sound.doubted.iter().all(|out| out.frame != *frame));
            sound.stay = sound.doubted.len() > most || Poses::new(examples, &frames).are_one();
            if sound.stay {
                sound.training = Training::new(examples, progress)?;
                break;
            }
            sound.training = Training::of(examples, &frames, progress)?;
        }
        Ok(sound)
    }

    /// Lists the frames that are left out, the worst of each look first.
    pub fn left_out(&self) -> &[Doubted] {
        if self.stay { &[] } else { &self.doubted }
    }

    /// Gives the training with each frame as often as it counts: of frames that stand there twice each would vouch for the
    /// other, so that this comes last.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn weighted(
        self,
        examples: &Examples,
        progress: &dyn Progress,
    ) -> Result<Training, FitError> {
        let frames = self.training.poses.frames();
        let repeated = examples.repeated(&frames);
        if repeated.len() == frames.len() {
            return Ok(self.training);
        }
        Training::of(examples, &repeated, progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    /// Poses, and how many of the last ones explode.
    fn look(poses: usize, broken: usize) -> (Vec<usize>, Sound) {
        let mut examples = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed: 1 });
        let first = (poses - broken) * examples.vertex_len();
        let size = 0.07 * examples.diagonal();
        for (i, x) in examples.vertices[first..].iter_mut().flatten().enumerate() {
            *x += size * (12.9898 * i as f64).sin();
        }
        let sound = Sound::new(&examples, &Silent).unwrap();
        let mut named: Vec<usize> = sound.doubted.iter().map(|of| of.frame).collect();
        named.sort_unstable();
        (named, sound)
    }

    #[test]
    fn a_quarter_is_left_out_more_stay_and_are_named_and_six_are_kept() {
        for (poses, broken, left_out) in [(20, 5, 5), (30, 8, 0), (7, 1, 1), (6, 1, 0)] {
            let (named, sound) = look(poses, broken);
            assert_eq!(named, Vec::from_iter(poses - broken..poses));
            assert_eq!(sound.left_out().len(), left_out);
            assert_eq!(sound.training.poses.len(), poses - left_out);
        }
    }
}
