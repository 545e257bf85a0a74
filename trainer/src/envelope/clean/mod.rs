//! Outlier frames, whose meshes do not belong to their poses, and a training on the inlier frames.

mod outliers;
mod region;

pub use outliers::{OutlierPose, RigidOffset, outliers, rigid_offsets};
pub use region::{HOPS, Region, compared, regions};

use crate::Error;
use crate::envelope::lbs::poses::MIN_POSES;
use crate::envelope::lbs::training::Training;
use crate::examples::{Examples, Split, spread};
use crate::progress::Progress;
use outliers::{MOST, ROUNDS};
use region::VERTICES;
use serde::Serialize;

/// Training frame whose mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OutlierFrame {
    /// Index of the frame.
    pub frame: usize,
    /// Distance of the mesh from its prediction by the other frames, RMS in % of the diagonal. For a rigid offset, the
    /// length of the offset.
    pub percent: f64,
    /// Usual error at this pose, in % of the diagonal.
    pub usual_percent: f64,
}

/// Inlier frames of a training, and the outlier frames.
pub struct Inliers<'a> {
    /// Training on the inlier frames, each frame once. Contains the outliers too if they are kept.
    pub training: Training<'a>,
    /// Outlier frames, the worst first.
    pub outliers: Vec<OutlierFrame>,
    /// Whether the training keeps the outliers. Without them too few frames, or no motion, would be left.
    pub keeps_outliers: bool,
}

impl<'a> Inliers<'a> {
    /// Finds the outliers among the training frames, on some of the vertices. Meshes that are skinned by the scene
    /// itself have no outliers.
    ///
    /// Each round judges all frames by LBS fitted without the last round's outliers. So a good frame comes back if only
    /// a wrong frame made it an outlier.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn new(examples: &'a Examples, progress: &dyn Progress) -> Result<Self, Error> {
        let frames = examples.frames_of(Split::Train);
        let all = Training::of(examples, &frames, progress)?;
        let without_outliers = |all: Training<'a>| Self {
            training: all.pulled(),
            outliers: Vec::new(),
            keeps_outliers: false,
        };
        if examples.own_skin {
            return Ok(without_outliers(all));
        }
        let every = Vec::from_iter(0..frames.len());
        let vertices = spread(examples.vertex_len(), VERTICES);
        let mut few = all.part(&vertices, &every);
        progress.step("frames", 1);
        let mut found = outliers(&few, &[]);
        if found.is_empty() {
            return Ok(without_outliers(all));
        }
        let most = (MOST * frames.len() as f64).max(1.0) as usize;
        let most = most.min(frames.len() - MIN_POSES);
        let others = |out: &[usize]| -> Vec<usize> {
            every.iter().copied().filter(|pose| !out.contains(pose)).collect()
        };
        let may_leave_out =
            |out: &[usize]| out.len() <= most && !all.poses.only(&others(out)).are_equal();
        let mut out = Vec::new();
        for _ in 0..ROUNDS {
            let next = poses(&found);
            if next == out || !may_leave_out(&next) {
                break;
            }
            few.lbs = all.part(&vertices, &others(&next)).lbs;
            progress.step("frames", 1);
            out = next;
            found = outliers(&few, &out);
        }
        let out = poses(&found);
        let keeps_outliers = !may_leave_out(&out);
        let kept = if keeps_outliers { every } else { others(&out) };
        let kept: Vec<usize> = kept.into_iter().map(|pose| frames[pose]).collect();
        drop(all);
        let training = Training::of(examples, &kept, progress)?.pulled();
        let frame = |&OutlierPose { pose, error, usual }: &OutlierPose| OutlierFrame {
            frame: frames[pose],
            percent: 100.0 * error,
            usual_percent: 100.0 * usual,
        };
        Ok(Self { training, outliers: found.iter().map(frame).collect(), keeps_outliers })
    }

    /// Lists the outliers that the training leaves out, the worst first.
    pub fn left_out(&self) -> &[OutlierFrame] {
        if self.keeps_outliers { &[] } else { &self.outliers }
    }

    /// Repeats frames according to their weights. Repeats are added last, or they validate each other.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn weighted(self, progress: &dyn Progress) -> Result<Training<'a>, Error> {
        let examples = self.training.examples;
        let frames = self.training.poses.frames();
        let repeated = examples.repeated(&frames);
        if repeated.len() == frames.len() {
            return Ok(self.training);
        }
        Ok(Training::of(examples, &repeated, progress)?.pulled())
    }
}

/// Lists the pose indices of outliers in ascending order.
fn poses(found: &[OutlierPose]) -> Vec<usize> {
    let mut poses: Vec<usize> = found.iter().map(|broken| broken.pose).collect();
    poses.sort_unstable();
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    /// Finds the outliers of a demo whose last meshes explode. Returns the outlier frames, and the numbers of frames
    /// that are left out and that are trained on.
    fn find(poses: usize, broken: usize) -> (Vec<usize>, [usize; 2]) {
        let mut examples = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed: 1 });
        let first = (poses - broken) * examples.vertex_len();
        let size = 0.07 * examples.diagonal();
        for (i, x) in examples.vertices[first..].iter_mut().flatten().enumerate() {
            *x += size * (12.9898 * i as f64).sin();
        }
        let found = Inliers::new(&examples, &Silent).unwrap();
        let mut named: Vec<usize> = found.outliers.iter().map(|of| of.frame).collect();
        named.sort_unstable();
        (named, [found.left_out().len(), found.training.poses.len()])
    }

    #[test]
    fn at_most_a_quarter_is_left_out_and_six_frames_are_kept() {
        for (poses, broken, left_out) in [(20, 5, 5), (30, 8, 0), (7, 1, 1), (6, 1, 0)] {
            let (named, counts) = find(poses, broken);
            assert_eq!(named, Vec::from_iter(poses - broken..poses));
            assert_eq!(counts, [left_out, poses - left_out]);
        }
    }
}
