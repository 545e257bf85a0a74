//! Frames whose meshes do not belong to their poses: a simulation that exploded, a mesh that is moved or a frame late.
//!
//! The other frames predict each frame from its pose. The error is measured against the uncertainty of the prediction:
//! a pose unlike all others may be predicted badly. A wrong frame spoils the predictions of its neighbours, so only inlier
//! frames predict. Frames are judged again each time the inliers change.

use super::moved::stands;
use super::region::{POSES, Region, regions};
use crate::envelope::lbs::residuals::Residuals;
use crate::envelope::lbs::training::Training;

/// A wrong frame has more than this multiple of the usual error. At 4 sound frames of small sets are named; at 6 an exploded
/// frame of 12 is missed.
const TIMES: f64 = 5.0;
/// Least error that is usual in a pose unlike all others, RMS in diagonals. LBS has an error of 0.003 to 0.007 on
/// the arm, the leg and the bone.
const BULGE: f64 = 0.005;
/// From this number of frames on a wrong frame may have a smaller error than LBS. The bound falls with the root of the
/// number, as many frames predict each other well.
const FEW: f64 = 16.0;
/// How often at most frames are judged again, as the inliers or LBS change.
pub(super) const ROUNDS: usize = 4;
/// Largest share of wrong frames: more are no exceptions, and stay.
pub(super) const MOST: f64 = 0.25;

/// A frame whose mesh does not belong to its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Broken {
    /// Its number among the training poses.
    pub pose: usize,
    /// Its distance from where the others predict it, RMS in diagonals. For a mesh that stands elsewhere, the distance from
    /// its joints.
    pub error: f64,
    /// The error that is usual at this pose.
    pub usual: f64,
}

/// Finds the training frames whose meshes do not belong to their poses. Sorts them by error over usual error, the largest
/// first.
///
/// - `out`: poses that LBS was fitted without. Other poses that stand elsewhere bend LBS, and are found alone.
pub fn broken(training: &Training, out: &[usize]) -> Vec<Broken> {
    let (left, dominant) = training.left_by_lbs();
    let residuals = Residuals { training, left: &left, dominant: &dominant };
    let mut found = elsewhere(residuals);
    if found.iter().all(|broken| out.contains(&broken.pose)) {
        let rest = without(training.poses.len(), &found);
        let parts = rest.len().div_ceil(POSES);
        for part in 0..parts {
            let poses = Vec::from_iter(rest.iter().copied().skip(part).step_by(parts));
            found.extend(among(residuals, &poses));
        }
    }
    let times = |broken: &Broken| broken.error / broken.usual;
    found.sort_by(|a, b| times(b).total_cmp(&times(a)));
    found
}

/// Finds the frames that stand elsewhere than their joints; none if most frames do.
fn elsewhere(residuals: Residuals<'_>) -> Vec<Broken> {
    let all = stands(residuals);
    let usual = middle(all.iter().map(|stand| stand.moved).collect());
    let found = all.iter().enumerate().filter(|(_, stand)| stand.is_elsewhere());
    let found: Vec<Broken> =
        found.map(|(pose, stand)| Broken { pose, error: stand.moved, usual }).collect();
    if 2 * found.len() < all.len() { found } else { Vec::new() }
}

/// Finds the wrong frames among some poses.
fn among(residuals: Residuals<'_>, poses: &[usize]) -> Vec<Broken> {
    let regions = regions(residuals, poses);
    let left = |i: usize| regions.iter().map(|region| region.regression.left(i)).sum();
    let compared = Compared {
        left: (0..poses.len()).map(left).collect(),
        vertex_len: regions.iter().map(|region| region.vertex_len as f64).sum(),
        regions,
    };
    let found = compared.outliers().unwrap_or_default();
    found.into_iter().map(|broken| Broken { pose: poses[broken.pose], ..broken }).collect()
}

/// Poses that are compared.
struct Compared {
    /// The skin of each joint.
    regions: Vec<Region>,
    /// Squared error of LBS in each pose, summed over the regions.
    left: Vec<f64>,
    /// Vertices of all regions.
    vertex_len: f64,
}

impl Compared {
    /// Finds the wrong frames. The first inliers are those with the smallest standardised residuals.
    fn outliers(&self) -> Option<Vec<Broken>> {
        let n = self.left.len();
        let all = self.errors(&Vec::from_iter(0..n))?;
        let mut inliers: Vec<usize> = (0..n).collect();
        inliers.sort_by(|&a, &b| all[a].0.total_cmp(&all[b].0));
        inliers.truncate(n - ((MOST * n as f64) as usize).max(1));
        inliers.sort_unstable();
        let mut found = Vec::new();
        for _ in 0..ROUNDS {
            found = self.judged_by(&inliers)?;
            let belong = without(n, &found);
            if belong == inliers || 2 * belong.len() < n {
                break;
            }
            inliers = belong;
        }
        Some(found)
    }

    /// Finds the poses whose errors are much larger than usual, as inliers predict them.
    ///
    /// The usual squared error is the variance of the prediction, times the median standardised residual of the inliers. It
    /// is at most the squared error of LBS.
    fn judged_by(&self, inliers: &[usize]) -> Option<Vec<Broken>> {
        let bulge = BULGE.powi(2) * self.vertex_len;
        let errors = self.errors(inliers)?;
        let usual = middle(inliers.iter().map(|&i| errors[i].0).collect()).max(bulge);
        let judge = |i: usize| {
            let (standardised, squared) = errors[i];
            let others = inliers.iter().filter(|&&other| other != i);
            let count = others.clone().count().max(1) as f64;
            let lbs = others.map(|&other| self.left[other]).sum::<f64>() / count;
            let times = (standardised / usual).max(squared / lbs.max(bulge)).sqrt();
            let is_wrong = times > TIMES && squared > FEW / (count + 1.0) * lbs;
            let error = (squared / self.vertex_len).sqrt();
            is_wrong.then_some(Broken { pose: i, error, usual: error / times })
        };
        Some((0..self.left.len()).filter_map(judge).collect())
    }

    /// Predicts each pose by the inliers among the others: squared errors over their variance, and squared errors, both
    /// summed over the regions.
    fn errors(&self, inliers: &[usize]) -> Option<Vec<(f64, f64)>> {
        let mut sums = vec![(0.0, 0.0); self.left.len()];
        for region in &self.regions {
            for (sum, own) in sums.iter_mut().zip(region.regression.standardised_errors(inliers)?) {
                *sum = (sum.0 + own.0, sum.1 + own.1);
            }
        }
        Some(sums)
    }
}

/// Lists the poses, n in all, that are not among the found ones.
fn without(n: usize, found: &[Broken]) -> Vec<usize> {
    (0..n).filter(|&pose| found.iter().all(|broken| broken.pose != pose)).collect()
}

/// Returns the median, 0 without values.
fn middle(mut values: Vec<f64>) -> f64 {
    let place = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::lbs::poses::Poses;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::examples::{Examples, Split};
    use crate::progress::Silent;
    use std::ops::Range;

    const FRAME: usize = 17;

    fn examples() -> Examples {
        demo(&DemoOptions { vertices: 300, poses: 60, held_out: 0, seed: 1 })
    }

    fn found(examples: &Examples) -> Vec<usize> {
        let training = Training::new(examples, &Silent).unwrap();
        broken(&training, &[]).iter().map(|broken| broken.pose).collect()
    }

    #[test]
    fn sound_frames_are_left_in() {
        for (seed, poses) in [(1, 40), (2, 40), (3, 40), (4, 7), (5, 9), (6, 12), (7, 20)] {
            let examples = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed });
            assert!(found(&examples).is_empty(), "{poses}");
        }
    }

    #[test]
    fn a_sound_pose_like_no_other_is_left_in() {
        // The frames near rest, and the one that is farthest from it.
        let all = demo(&DemoOptions { vertices: 300, poses: 80, held_out: 0, seed: 2 });
        let frames: Vec<usize> = (0..80).collect();
        let poses = Poses::new(&all, &frames);
        let bent = |&frame: &usize| -> f64 {
            (0..all.joint_len()).map(|joint| poses.angle(frame, joint).norm_squared()).sum()
        };
        let mut order = frames;
        order.sort_by(|a, b| bent(a).total_cmp(&bent(b)));
        let mut apart = all.clone();
        apart.split.fill(Split::HeldOut);
        order[..40].iter().chain(&order[79..]).for_each(|&i| apart.split[i] = Split::Train);
        assert!(found(&apart).is_empty());
    }

    /// Moves the meshes of some frames, or lets them explode.
    fn spoil(examples: &mut Examples, frames: Range<usize>, explodes: bool) {
        let (len, diagonal) = (examples.vertex_len(), examples.diagonal());
        let own = frames.start * len..frames.end * len;
        for (i, x) in examples.vertices[own].iter_mut().enumerate() {
            let noise = |k: usize| 0.07 * diagonal * (12.9898 * (3 * i + k) as f64).sin();
            let moved = [0.0, 0.2 * diagonal, 0.0];
            (0..3).for_each(|k| x[k] += if explodes { noise(k) } else { moved[k] });
        }
    }

    #[test]
    fn meshes_that_are_moved_exploded_or_late_are_found() {
        let (sound, len) = (examples(), examples().vertex_len());
        for explodes in [false, true] {
            let mut spoiled = sound.clone();
            spoil(&mut spoiled, FRAME..FRAME + 1, explodes);
            assert_eq!(found(&spoiled), [FRAME]);
        }
        let mut late = sound;
        late.vertices.copy_within((FRAME - 1) * len..FRAME * len, FRAME * len);
        assert_eq!(found(&late), [FRAME]);
    }

    #[test]
    fn each_of_few_frames_is_found() {
        for poses in [7, 12] {
            let sound = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed: 1 });
            for (frame, explodes) in (0..poses).flat_map(|frame| [(frame, false), (frame, true)]) {
                let mut spoiled = sound.clone();
                spoil(&mut spoiled, frame..frame + 1, explodes);
                assert_eq!(found(&spoiled), [frame], "of {poses}");
            }
        }
    }

    #[test]
    fn nearly_half_that_are_moved_alike_are_found() {
        let mut spoiled = examples();
        spoil(&mut spoiled, 10..38, false);
        let mut found = found(&spoiled);
        found.sort_unstable();
        assert_eq!(found, Vec::from_iter(10..38));
    }

    #[test]
    fn several_in_a_row_are_found_without_their_neighbours() {
        for (frames, explodes) in [(20..24, false), (20..24, true), (30..40, true)] {
            let mut spoiled = examples();
            spoil(&mut spoiled, frames.clone(), explodes);
            let mut found = found(&spoiled);
            found.sort_unstable();
            assert_eq!(found, Vec::from_iter(frames));
        }
    }
}
