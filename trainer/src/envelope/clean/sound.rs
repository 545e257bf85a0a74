//! A training on the frames that belong to their poses.

use super::broken::{Broken, MOST, ROUNDS, broken};
use super::region::VERTICES;
use crate::envelope::error::FitError;
use crate::envelope::lbs::poses::MIN_POSES;
use crate::envelope::lbs::training::Training;
use crate::examples::{Examples, Split, spread};
use crate::progress::Progress;
use serde::Serialize;

/// A training frame whose mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Doubted {
    /// The frame.
    pub frame: usize,
    /// Its distance from where the others predict it, RMS in % of the diagonal. For a mesh that stands elsewhere, the distance
    /// from its joints.
    pub percent: f64,
    /// The error that is usual at its pose, in % of the diagonal.
    pub usual_percent: f64,
}

/// The training frames whose meshes belong to their poses, and the others.
pub struct Sound<'a> {
    /// A training on the frames that belong to their poses, once each, and on those that stay.
    pub training: Training<'a>,
    /// The others, the worst first.
    pub doubted: Vec<Doubted>,
    /// Whether they stay in the training, for it would have too few frames, or no motion, without them.
    pub stay: bool,
}

impl<'a> Sound<'a> {
    /// Looks at some vertices of the training frames of the examples. Meshes of the scene's own skin all belong to their
    /// poses.
    ///
    /// Each look judges all frames by LBS that is fitted without those of the look before: a frame that a wrong one made
    /// look wrong comes back.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn new(examples: &'a Examples, progress: &dyn Progress) -> Result<Self, FitError> {
        let frames = examples.frames_of(Split::Train);
        let all = Training::of(examples, &frames, progress)?;
        let sound =
            |all: Training<'a>| Self { training: all.pulled(), doubted: Vec::new(), stay: false };
        if examples.own_skin {
            return Ok(sound(all));
        }
        let every = Vec::from_iter(0..frames.len());
        let seen = spread(examples.vertex_len(), VERTICES);
        let mut few = all.part(&seen, &every);
        progress.step("frames", 1);
        let mut found = broken(&few, &[]);
        if found.is_empty() {
            return Ok(sound(all));
        }
        let most = (MOST * frames.len() as f64).max(1.0) as usize;
        let most = most.min(frames.len() - MIN_POSES);
        let others = |out: &[usize]| -> Vec<usize> {
            every.iter().copied().filter(|pose| !out.contains(pose)).collect()
        };
        let is_fair = |out: &[usize]| out.len() <= most && !all.poses.only(&others(out)).are_one();
        let mut out = Vec::new();
        for _ in 0..ROUNDS {
            let next = poses(&found);
            if next == out || !is_fair(&next) {
                break;
            }
            few.lbs = all.part(&seen, &others(&next)).lbs;
            progress.step("frames", 1);
            out = next;
            found = broken(&few, &out);
        }
        let out = poses(&found);
        let stay = !is_fair(&out);
        let kept = if stay { every } else { others(&out) };
        let kept: Vec<usize> = kept.into_iter().map(|pose| frames[pose]).collect();
        drop(all);
        let training = Training::of(examples, &kept, progress)?.pulled();
        let doubted = |&Broken { pose, error, usual }: &Broken| Doubted {
            frame: frames[pose],
            percent: 100.0 * error,
            usual_percent: 100.0 * usual,
        };
        Ok(Self { training, doubted: found.iter().map(doubted).collect(), stay })
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
    pub fn weighted(self, progress: &dyn Progress) -> Result<Training<'a>, FitError> {
        let examples = self.training.examples;
        let frames = self.training.poses.frames();
        let repeated = examples.repeated(&frames);
        if repeated.len() == frames.len() {
            return Ok(self.training);
        }
        Ok(Training::of(examples, &repeated, progress)?.pulled())
    }
}

/// Lists the poses of found frames in order.
fn poses(found: &[Broken]) -> Vec<usize> {
    let mut poses: Vec<usize> = found.iter().map(|broken| broken.pose).collect();
    poses.sort_unstable();
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    /// Looks at poses of which the last ones explode. Returns the frames that are named, and how many are left out and how
    /// many kept.
    fn look(poses: usize, broken: usize) -> (Vec<usize>, [usize; 2]) {
        let mut examples = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed: 1 });
        let first = (poses - broken) * examples.vertex_len();
        let size = 0.07 * examples.diagonal();
        for (i, x) in examples.vertices[first..].iter_mut().flatten().enumerate() {
            *x += size * (12.9898 * i as f64).sin();
        }
        let sound = Sound::new(&examples, &Silent).unwrap();
        let mut named: Vec<usize> = sound.doubted.iter().map(|of| of.frame).collect();
        named.sort_unstable();
        (named, [sound.left_out().len(), sound.training.poses.len()])
    }

    #[test]
    fn a_quarter_is_left_out_more_stay_and_are_named_and_six_are_kept() {
        for (poses, broken, left_out) in [(20, 5, 5), (30, 8, 0), (7, 1, 1), (6, 1, 0)] {
            let (named, counts) = look(poses, broken);
            assert_eq!(named, Vec::from_iter(poses - broken..poses));
            assert_eq!(counts, [left_out, poses - left_out]);
        }
    }
}
