//! Frames whose meshes do not belong to their poses: a simulation that exploded, a mesh that is moved or a frame late.
//!
//! Each frame is predicted by others from its pose, and its error is measured against what the prediction is unsure of: a
//! pose like no other may be predicted badly, up to what skinning errs by there, one among others may not. Where other frames
//! hardly move the joints of a region, they say nothing of its skin in frames that do. A frame that is an
//! order of magnitude worse than is usual spoils the prediction of its neighbours too, and of few frames that of all: so
//! frames are judged by those alone that belong to their meshes, in turn with which those are.

use super::moved::{Stand, stands};
use super::region::{Region, regions};
use crate::envelope::skin::residuals::Residuals;
use crate::envelope::skin::training::Training;
use crate::kernel::gram::GramRegression;

/// How many times a frame's error is what is usual.
const TIMES: f64 = 10.0;
/// How many times farther from all others a pose stands alone than nine of ten do, and how many times larger than theirs,
/// as LBS leaves it, the error of such a pose may be: of it the others tell little.
const ALONE: f64 = 3.0;
/// How many times farther from rest a pose moves a region's joints than any other, from where the others say nothing of it.
const UNKNOWN: f64 = 10.0;
/// Error below which no frame is wrong, RMS over the skin in diagonals.
pub(super) const RIGHT: f64 = 1e-4;
/// Fewest others that must move as far for a pose to be known.
const FEWEST: usize = 5;
/// Share of the frames that do not judge the others to begin with, those that surprise most, and how often all are judged.
const SUSPECTED: f64 = 0.25;
const ROUNDS: usize = 10;
/// Share of the frames that others are compared with.
const MOST_FRAMES: f64 = 0.9;
/// Share of the RMS error of LBS below which an error spoils nothing.
const SHARE: f64 = 0.3;
/// Frames up to which an error is to be as large as that of LBS: what so few tell of each other is little.
const FEW: f64 = 16.0;
/// Most frames that are compared at once: the work grows with their cube.
const FRAMES: usize = 300;

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
    /// Whether enough others move at least a tenth as far. If not, only an exact skin shows that the mesh is wrong.
    pub is_known: bool,
}

impl Broken {
    /// Returns how many times its error is the usual one: a measure to sort by, as the usual one may be nearly nothing.
    pub(super) fn times(&self) -> f64 {
        self.error / self.usual
    }
}

/// Finds the training frames whose meshes do not belong to their poses, the worst first.
///
/// - `out`: poses that LBS was fitted without. They are judged, and judge no other where they stand elsewhere.
pub fn broken(training: &Training, out: &[usize]) -> Vec<Broken> {
    let (left, dominant) = training.left_by_lbs();
    let residuals = Residuals { training, left: &left, dominant: &dominant };
    let mut found = elsewhere(residuals);
    let is_new = |broken: &Broken| !out.contains(&broken.pose);
    if !found.iter().any(is_new) {
        let is_moved = |pose: &usize| found.iter().any(|broken| broken.pose == *pose);
        let rest: Vec<usize> = (0..training.poses.len()).filter(|pose| !is_moved(pose)).collect();
        let parts = rest.len().div_ceil(FRAMES);
        let poses = |part| Vec::from_iter(rest.iter().copied().skip(part).step_by(parts));
        found
            .extend((0..parts).flat_map(|part| among(residuals, &poses(part))).collect::<Vec<_>>());
    }
    found.sort_by(|a, b| b.times().total_cmp(&a.times()));
    found
}

/// Those that stand elsewhere than their joints, where most do not. The others are judged when LBS is fitted without them.
fn elsewhere(residuals: Residuals<'_>) -> Vec<Broken> {
    let all = stands(residuals);
    let usual = middle(all.iter().map(|stand| stand.moved).collect());
    let is_elsewhere = |(_, stand): &(usize, Stand)| stand.is_elsewhere();
    let found = all.iter().copied().enumerate().filter(is_elsewhere);
    let found: Vec<Broken> = found
        .map(|(pose, stand)| Broken { pose, error: stand.moved, usual, is_known: true })
        .collect();
    if 2 * found.len() < all.len() { found } else { Vec::new() }
}

fn among(residuals: Residuals<'_>, poses: &[usize]) -> Vec<Broken> {
    let regions = regions(residuals, poses);
    let left = |i: usize| regions.iter().map(|r| r.regression.left(i)).sum::<f64>();
    let vertex_len = regions.iter().map(|r| r.vertex_len).sum();
    let moved = |i: usize| regions.iter().map(|r| r.regression.moved(i)).sum::<f64>();
    let [left, moved] =
        [&left as &dyn Fn(usize) -> f64, &moved].map(|of| (0..poses.len()).map(of).collect());
    let compared = Compared { left, moved, regions, vertex_len };
    let judged = compared.judged().unwrap_or_default();
    let named = |broken: Broken| Broken { pose: poses[broken.pose], ..broken };
    judged.into_iter().flatten().map(named).collect()
}

/// Poses that are compared.
struct Compared {
    /// What of each joint's skin they predict of each other.
    regions: Vec<Region>,
    /// Squared error of LBS in each, of the skin that the regions look at.
    left: Vec<f64>,
    /// Squared distance of each from rest, summed over the regions.
    moved: Vec<f64>,
    /// Vertices that the regions look at.
    vertex_len: usize,
}

/// A squared error as others predict it.
#[derive(Clone, Copy, Default)]
struct Missed {
    /// Over what the prediction is unsure of.
    surprise: f64,
    squared: f64,
}

impl Compared {
    /// Judges every pose by those that belong to their meshes. Returns the error of each wrong pose, and the usual error
    /// there. The first to judge are those that surprise least.
    fn judged(&self) -> Option<Vec<Option<Broken>>> {
        let n = self.left.len();
        let all = self.missed(&Vec::from_iter(0..n))?;
        let mut judges: Vec<usize> = (0..n).collect();
        judges.sort_by(|&a, &b| all[a].surprise.total_cmp(&all[b].surprise));
        judges.truncate(n - ((SUSPECTED * n as f64) as usize).max(1));
        judges.sort_unstable();
        let mut judged = Vec::new();
        for _ in 0..ROUNDS {
            judged = self.judged_by(&judges)?;
            let belong: Vec<usize> = (0..n).filter(|&i| judged[i].is_none()).collect();
            if belong == judges || 2 * belong.len() < n {
                break;
            }
            judges = belong;
        }
        Some(judged)
    }

    fn judged_by(&self, judges: &[usize]) -> Option<Vec<Option<Broken>>> {
        let right = RIGHT.powi(2) * self.vertex_len as f64;
        let missed = self.missed(judges)?;
        let usual = judges.iter().map(|&i| missed[i].surprise).collect();
        let usual = middle(usual).max(f64::MIN_POSITIVE);
        let judge = |i: usize| {
            let Missed { surprise, squared } = missed[i];
            let times = (surprise / usual).sqrt();
            let others: Vec<usize> = judges.iter().copied().filter(|&other| other != i).collect();
            let left: Vec<f64> = others.iter().map(|&other| self.left[other]).collect();
            let share = (FEW / (others.len() + 1) as f64).clamp(SHARE, 1.0);
            let mean = left.iter().sum::<f64>() / left.len().max(1) as f64;
            let is_seen = times >= ALONE && squared > (share.powi(2) * mean).max(right);
            let is_broken = is_seen
                && match self.is_alone(i, &others) {
                    true => times >= TIMES && squared > ALONE.powi(2) * most(left),
                    false => {
                        let largest = left.into_iter().fold(0.0, f64::max);
                        times >= TIMES || squared > ALONE.powi(2) * largest
                    }
                };
            let error = (squared / self.vertex_len as f64).sqrt();
            let far = self.moved[i] / UNKNOWN.powi(2);
            let is_known =
                others.iter().filter(|&&other| self.moved[other] >= far).count() >= FEWEST;
            is_broken.then_some(Broken { pose: i, error, usual: error / times, is_known })
        };
        Some((0..self.left.len()).map(judge).collect())
    }

    /// Whether a pose is much farther from all others than they are from each other.
    fn is_alone(&self, pose: usize, others: &[usize]) -> bool {
        let with = [&[pose], others].concat();
        let mut apart = vec![0.0; with.len()];
        for region in &self.regions {
            apart.iter_mut().zip(region.regression.apart(&with)).for_each(|(sum, own)| *sum += own);
        }
        let own = apart[0];
        own > ALONE.powi(2) * most(apart)
    }

    /// How far each pose is missed by those of some that are others, summed over the joints of which they know.
    fn missed(&self, by: &[usize]) -> Option<Vec<Missed>> {
        let mut sums = vec![Missed::default(); self.left.len()];
        for Region { regression, .. } in &self.regions {
            let is_known = known(regression, by);
            let missed = regression.surprises(by)?.into_iter().zip(is_known);
            for (sum, ((surprise, squared), is_known)) in sums.iter_mut().zip(missed) {
                if is_known {
                    sum.surprise += surprise;
                    sum.squared += squared;
                }
            }
        }
        Some(sums)
    }
}

/// Tells of each pose whether another one of some moves a region's joints at least a tenth as far from rest.
fn known(regression: &GramRegression, by: &[usize]) -> Vec<bool> {
    let mut farthest: Vec<(f64, usize)> = by.iter().map(|&i| (regression.moved(i), i)).collect();
    farthest.sort_by(|a, b| b.0.total_cmp(&a.0));
    let of_pose = |pose: usize| {
        let other = farthest.iter().find(|far| far.1 != pose).map_or(0.0, |far| far.0);
        other * UNKNOWN.powi(2) >= regression.moved(pose)
    };
    (0..regression.sample_len()).map(of_pose).collect()
}

/// The middle one of some values.
fn middle(mut values: Vec<f64>) -> f64 {
    let place = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(place, f64::total_cmp).1 }
}

/// What most of some values do not exceed.
fn most(mut values: Vec<f64>) -> f64 {
    let place = (MOST_FRAMES * values.len() as f64) as usize;
    if place < values.len() { *values.select_nth_unstable_by(place, f64::total_cmp).1 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::envelope::skin::poses::Poses;
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
