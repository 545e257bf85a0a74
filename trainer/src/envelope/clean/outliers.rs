//! Outlier poses, whose meshes do not belong: an exploded simulation, a mesh with a rigid offset, or a mesh that is one
//! frame late.
//!
//! The other frames predict each frame from its pose. The error is measured against the uncertainty of the prediction:
//! a pose unlike all others may be predicted badly. A wrong frame spoils the predictions of its neighbours, so only
//! inlier frames predict. Frames are judged again each time the inliers change.
//!
//! A rigid offset is found without the other frames: LBS blends joint transforms, and no blend moves a mesh as a whole.
//! So even many equal offsets are found.

use super::region::{POSES, Region, regions};
use crate::envelope::lbs::training::{Residuals, Training};
use crate::numeric::so3;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// An outlier has more than this multiple of the usual error. A bound of 4 flags inliers of small sets. A bound of 6
/// misses an exploded frame among 12.
const TIMES: f64 = 5.0;
/// Smallest usual error in a pose unlike all others, RMS in diagonals. LBS has an error of 0.003 to 0.007 on the arm,
/// the leg and the bone.
const BULGE: f64 = 0.005;
/// From this number of frames, an outlier may have a smaller error than LBS. The bound falls with the root of the
/// number, because many frames predict each other well.
const FEW: f64 = 16.0;
/// Largest number of rounds, as the inliers or LBS change.
pub(super) const ROUNDS: usize = 4;
/// Largest share of outliers. If more frames are flagged, they are not exceptions and stay.
pub(super) const MOST: f64 = 0.25;
/// Smallest length of a rigid offset, RMS in diagonals. Inlier frames have up to a quarter of this.
const FAR: f64 = 0.02;
/// Largest share of the squared error that may be left without the rigid offset. On an inlier nearly all error is left.
/// The exception is a small set in which one wrong frame bends LBS: then twice this share is left.
const REMAINING: f64 = 0.02;

/// Training pose whose mesh does not belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlierPose {
    /// Index among the training poses.
    pub pose: usize,
    /// Distance of the mesh from its prediction by the other poses, RMS in diagonals. For a rigid offset, the length of
    /// the offset.
    pub error: f64,
    /// Usual error at this pose, RMS in diagonals.
    pub usual: f64,
}

/// Rigid motion that brings the skinned mesh of a pose nearest to the true mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidOffset {
    /// Distance of the rigid motion, RMS in diagonals.
    pub distance: f64,
    /// Share of the squared error that is left after the rigid motion.
    pub remaining: f64,
}

impl RigidOffset {
    /// Returns whether the offset is long and leaves less than a share `most` of the squared error.
    pub fn is_offset(&self, most: f64) -> bool {
        self.distance > FAR && self.remaining < most
    }
}

/// Finds the outlier poses, sorted by error over usual error, the largest first.
///
/// - `out`: poses that LBS was fitted without. Any other pose with a rigid offset bends LBS. Then only rigid offsets
///   are returned.
pub fn outliers(training: &Training, out: &[usize]) -> Vec<OutlierPose> {
    let (errors, dominant) = training.lbs_residuals();
    let residuals = Residuals { training, residuals: &errors, dominant: &dominant };
    let mut found = offset_poses(residuals);
    if found.iter().all(|outlier| out.contains(&outlier.pose)) {
        let rest = without(training.poses.len(), &found);
        let parts = rest.len().div_ceil(POSES);
        for part in 0..parts {
            let poses = Vec::from_iter(rest.iter().copied().skip(part).step_by(parts));
            found.extend(among(residuals, &poses));
        }
    }
    let times = |outlier: &OutlierPose| outlier.error / outlier.usual;
    found.sort_by(|a, b| times(b).total_cmp(&times(a)));
    found
}

/// Fits the rigid offset of each training frame, n.
pub fn rigid_offsets(residuals: Residuals<'_>) -> Vec<RigidOffset> {
    (0..residuals.training.poses.len())
        .into_par_iter()
        .map(|pose| rigid_offset(residuals, pose))
        .collect()
}

fn rigid_offset(Residuals { training, residuals, .. }: Residuals<'_>, pose: usize) -> RigidOffset {
    let len = training.rest.len();
    let at = |columns: &Mat<f64>, vertex: usize| {
        Vector3::from_column_slice(&columns.col_as_slice(vertex)[3 * pose..3 * pose + 3])
    };
    let truth = |vertex: usize| at(&training.trajectories, vertex);
    let skinned = |vertex: usize| truth(vertex) - at(residuals, vertex);
    let mean = |of: &dyn Fn(usize) -> Vector3<f64>| -> Vector3<f64> {
        (0..len).map(of).sum::<Vector3<f64>>() / len as f64
    };
    let [to, from] = [mean(&truth), mean(&skinned)];
    let spread: Matrix3<f64> =
        (0..len).map(|v| (truth(v) - to) * (skinned(v) - from).transpose()).sum();
    let turn = so3::polar(&spread).map_or(Matrix3::identity(), |(turn, _)| turn);
    let shifted = |v: usize| turn * (skinned(v) - from) + to;
    let sum = |of: &dyn Fn(usize) -> Vector3<f64>| -> f64 {
        (0..len).map(|v| of(v).norm_squared()).sum()
    };
    let offset = sum(&|v| shifted(v) - skinned(v));
    let error = sum(&|v| truth(v) - skinned(v)).max(f64::MIN_POSITIVE);
    RigidOffset {
        distance: (offset / len as f64).sqrt(),
        remaining: sum(&|v| truth(v) - shifted(v)) / error,
    }
}

/// Finds the poses with a rigid offset; none if most poses have one.
fn offset_poses(residuals: Residuals<'_>) -> Vec<OutlierPose> {
    let all = rigid_offsets(residuals);
    let usual = median(all.iter().map(|offset| offset.distance).collect());
    let found = all.iter().enumerate().filter(|(_, offset)| offset.is_offset(REMAINING));
    let found: Vec<OutlierPose> =
        found.map(|(pose, offset)| OutlierPose { pose, error: offset.distance, usual }).collect();
    if 2 * found.len() < all.len() { found } else { Vec::new() }
}

/// Finds the outliers among some poses.
fn among(residuals: Residuals<'_>, poses: &[usize]) -> Vec<OutlierPose> {
    let regions = regions(residuals, poses);
    let lbs_error = |i: usize| regions.iter().map(|region| region.regression.left(i)).sum();
    let compared = Compared {
        lbs_errors: (0..poses.len()).map(lbs_error).collect(),
        vertex_len: regions.iter().map(|region| region.vertex_len as f64).sum(),
        regions,
    };
    let found = compared.outliers().unwrap_or_default();
    found.into_iter().map(|found| OutlierPose { pose: poses[found.pose], ..found }).collect()
}

/// Poses that predict each other.
struct Compared {
    /// Skin of each joint.
    regions: Vec<Region>,
    /// Squared error of LBS in each pose, summed over the regions.
    lbs_errors: Vec<f64>,
    /// Number of sampled vertices of all regions.
    vertex_len: f64,
}

impl Compared {
    /// Finds the outliers. The first inliers are the poses with the smallest standardised residuals.
    fn outliers(&self) -> Option<Vec<OutlierPose>> {
        let n = self.lbs_errors.len();
        let all = self.errors(&Vec::from_iter(0..n))?;
        let mut inliers: Vec<usize> = (0..n).collect();
        inliers.sort_by(|&a, &b| all[a].0.total_cmp(&all[b].0));
        inliers.truncate(n - ((MOST * n as f64) as usize).max(1));
        inliers.sort_unstable();
        let mut found = Vec::new();
        for _ in 0..ROUNDS {
            found = self.predicted_by(&inliers)?;
            let belong = without(n, &found);
            if belong == inliers || 2 * belong.len() < n {
                break;
            }
            inliers = belong;
        }
        Some(found)
    }

    /// Finds the poses whose error is much larger than usual, if the inliers predict them.
    ///
    /// The usual squared error is the variance of the prediction times the median standardised residual of the inliers.
    /// The squared error of LBS limits it.
    fn predicted_by(&self, inliers: &[usize]) -> Option<Vec<OutlierPose>> {
        let bulge = BULGE.powi(2) * self.vertex_len;
        let errors = self.errors(inliers)?;
        let usual = median(inliers.iter().map(|&i| errors[i].0).collect()).max(bulge);
        let judge = |i: usize| {
            let (standardised, squared) = errors[i];
            let others = inliers.iter().filter(|&&other| other != i);
            let count = others.clone().count().max(1) as f64;
            let lbs = others.map(|&other| self.lbs_errors[other]).sum::<f64>() / count;
            let times = (standardised / usual).max(squared / lbs.max(bulge)).sqrt();
            let is_outlier = times > TIMES && squared > FEW / (count + 1.0) * lbs;
            let error = (squared / self.vertex_len).sqrt();
            is_outlier.then_some(OutlierPose { pose: i, error, usual: error / times })
        };
        Some((0..self.lbs_errors.len()).filter_map(judge).collect())
    }

    /// Predicts each pose from the other inliers. Returns the squared error over its variance, and the squared error,
    /// both summed over the regions.
    fn errors(&self, inliers: &[usize]) -> Option<Vec<(f64, f64)>> {
        let mut sums = vec![(0.0, 0.0); self.lbs_errors.len()];
        for region in &self.regions {
            for (sum, own) in sums.iter_mut().zip(region.regression.standardised_errors(inliers)?) {
                *sum = (sum.0 + own.0, sum.1 + own.1);
            }
        }
        Some(sums)
    }
}

/// Lists the poses among n that are not outliers.
fn without(n: usize, found: &[OutlierPose]) -> Vec<usize> {
    (0..n).filter(|&pose| found.iter().all(|outlier| outlier.pose != pose)).collect()
}

/// Returns the median, 0 without values.
fn median(mut values: Vec<f64>) -> f64 {
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
        outliers(&training, &[]).iter().map(|outlier| outlier.pose).collect()
    }

    #[test]
    fn good_frames_are_inliers() {
        for (seed, poses) in [(1, 40), (2, 40), (3, 40), (4, 7), (5, 9), (6, 12), (7, 20)] {
            let examples = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed });
            assert!(found(&examples).is_empty(), "{poses}");
        }
    }

    #[test]
    fn a_good_pose_unlike_all_others_is_an_inlier() {
        // Train on the frames near rest and on the frame farthest from rest.
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
    fn offset_exploded_and_late_meshes_are_found() {
        let (good, len) = (examples(), examples().vertex_len());
        for explodes in [false, true] {
            let mut spoiled = good.clone();
            spoil(&mut spoiled, FRAME..FRAME + 1, explodes);
            assert_eq!(found(&spoiled), [FRAME]);
        }
        let mut late = good;
        late.vertices.copy_within((FRAME - 1) * len..FRAME * len, FRAME * len);
        assert_eq!(found(&late), [FRAME]);
    }

    #[test]
    fn every_frame_of_a_small_set_is_found() {
        for poses in [7, 12] {
            let good = demo(&DemoOptions { vertices: 300, poses, held_out: 0, seed: 1 });
            for (frame, explodes) in (0..poses).flat_map(|frame| [(frame, false), (frame, true)]) {
                let mut spoiled = good.clone();
                spoil(&mut spoiled, frame..frame + 1, explodes);
                assert_eq!(found(&spoiled), [frame], "of {poses}");
            }
        }
    }

    #[test]
    fn equal_offsets_of_nearly_half_the_frames_are_found() {
        let mut spoiled = examples();
        spoil(&mut spoiled, 10..38, false);
        let mut found = found(&spoiled);
        found.sort_unstable();
        assert_eq!(found, Vec::from_iter(10..38));
    }

    #[test]
    fn consecutive_outliers_are_found_without_their_neighbours() {
        for (frames, explodes) in [(20..24, false), (20..24, true), (30..40, true)] {
            let mut spoiled = examples();
            spoil(&mut spoiled, frames.clone(), explodes);
            let mut found = found(&spoiled);
            found.sort_unstable();
            assert_eq!(found, Vec::from_iter(frames));
        }
    }
}
