//! Correction of helper transforms by local kernel maps from the pose (METHOD §1.9).
//!
//! `T_l(q) = base_l + Q_dom K_l(φ(q))`. Helpers with one dominant joint and one joint set are a group and share a
//! kernel map. The inputs are features of joints within some hops of the dominant joint. The outputs are a few latent
//! numbers: leading directions of the residual, measured on the skin.

pub mod candidates;
pub mod features;
pub mod joint_sets;
pub(super) mod rounding;
pub mod target;

use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::targets::{map_of, set_map};
use crate::envelope::model::Group;
use crate::numeric::affine::linear;
use crate::progress::Progress;
use candidates::{GroupCandidates, GroupReport};
use faer::Mat;
use joint_sets::JointSets;
use rayon::prelude::*;
use target::{CorrectionTarget, groups};

/// Name of the step.
const STEP: &str = "kernel maps";

/// Candidate maps of all groups, each in several sizes.
pub struct Search<'a> {
    target: CorrectionTarget<'a>,
    groups: Vec<GroupCandidates>,
}

/// Fitted maps of all groups.
pub struct Correction {
    /// Groups with their maps.
    pub groups: Vec<Group>,
    /// Report of each group.
    pub reports: Vec<GroupReport>,
    /// Bytes of the maps in the file.
    pub bytes: usize,
    /// Correction of each training pose by maps fitted without its fold, 3n x 4P.
    pub validated: Mat<f64>,
}

impl<'a> Search<'a> {
    /// Scores ridges, centres and ranks for every group.
    ///
    /// - `joint_sets`: chosen joint sets of each dominant joint.
    pub fn new(
        target: CorrectionTarget<'a>,
        joint_sets: &JointSets,
        progress: &dyn Progress,
    ) -> Self {
        let ranges = groups(target.dominant.len(), |helper| target.group_key(helper));
        progress.step(STEP, ranges.len());
        let search = |helpers| {
            let candidates = GroupCandidates::new(&target, helpers, joint_sets);
            progress.advance(1);
            candidates
        };
        let groups = ranges.into_par_iter().map(search).collect();
        Self { target, groups }
    }

    /// Chooses the sizes with the best scores within a number of bytes; `None` if no choice fits.
    fn within(&self, bytes: usize) -> Option<Vec<usize>> {
        let mut taken: Vec<usize> = self.groups.iter().map(|g| g.preferred).collect();
        let sum = |taken: &[usize]| -> usize {
            self.groups.iter().zip(taken).map(|(g, &t)| g.sizes[t].bytes).sum()
        };
        while sum(&taken) > bytes {
            // Take the step down with the smallest loss of score per byte saved.
            let steps = self.groups.iter().enumerate().flat_map(|(g, group)| {
                let from = &group.sizes[taken[g]];
                (0..taken[g]).map(move |to| {
                    let size = &group.sizes[to];
                    ((size.score - from.score) / (from.bytes - size.bytes) as f64, g, to)
                })
            });
            let (_, g, to) = steps.min_by(|a, b| a.0.total_cmp(&b.0))?;
            taken[g] = to;
        }
        // A step down may save more bytes than needed. Steps up use the remaining bytes, the largest gain first.
        loop {
            let left = bytes - sum(&taken);
            let steps = self.groups.iter().enumerate().flat_map(|(g, group)| {
                let from = &group.sizes[taken[g]];
                let above = taken[g] + 1..=group.preferred;
                let fits = above.filter(move |&to| group.sizes[to].bytes - from.bytes <= left);
                fits.map(move |to| (from.score - group.sizes[to].score, g, to))
            });
            let Some((_, g, to)) = steps.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            taken[g] = to;
        }
        Some(taken)
    }

    /// Returns groups without a correction.
    pub fn nothing(&self) -> Vec<Group> {
        self.groups.iter().map(GroupCandidates::nothing).collect()
    }

    /// Fits maps that add at most `bytes` to the file with [`Search::nothing`]; `None` if no choice fits.
    pub fn fit(&self, bytes: usize) -> Option<Correction> {
        let taken = self.within(bytes)?;
        let CorrectionTarget { poses, dominant, .. } = self.target;
        let fitted: Vec<_> = self
            .groups
            .par_iter()
            .zip(taken)
            .map(|(candidates, size)| candidates.fit(&self.target, &candidates.sizes[size]))
            .collect();
        let mut out = Correction {
            groups: Vec::new(),
            reports: Vec::new(),
            bytes: 0,
            validated: Mat::zeros(3 * poses.len(), 4 * dominant.len()),
        };
        for (group, report, predicted) in fitted {
            for pose in 0..poses.len() {
                let latents: Vec<f64> = predicted.row(pose).iter().copied().collect();
                add(&group, &latents, (poses, pose), &mut out.validated);
            }
            out.bytes += report.bytes;
            out.groups.push(group);
            out.reports.push(report);
        }
        Some(out)
    }
}

/// Adds `Q_dom K` for latent values to the transforms of a pose.
fn add(group: &Group, latents: &[f64], (poses, pose): (&Poses, usize), out: &mut Mat<f64>) {
    let turn = linear(poses.map(pose, group.joint));
    for (helper, map) in group.proxies.clone().zip(group.maps(latents)) {
        let corrected = map_of(out, pose, helper) + turn * map;
        set_map(out, pose, helper, &corrected);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::helpers::fit::HelperFit;
    use crate::envelope::lbs::targets::Targets;
    use crate::envelope::lbs::training::Training;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::examples::{Importance, Split};
    use crate::progress::Silent;

    #[test]
    fn held_out_poses_are_corrected_within_the_bytes_and_rest_is_exact() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 80, held_out: 20, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let helpers = HelperFit::new(&training, sinew_runtime::envelope::HelperKind::Affine)
            .unwrap()
            .run(20, 4);
        let target = helpers.target(&training);
        let search = Search::new(target, &joint_sets::choose(&target, &Silent), &Silent);
        let of = |bytes| -> (f64, usize) {
            let correction = search.fit(bytes).unwrap();
            let frames = examples.frames_of(Split::HeldOut);
            let (poses, trajectories) = training.view(&examples, &frames);
            let rest = &training.rest;
            let targets = Targets {
                rest,
                weights: &helpers.weights,
                trajectories: &trajectories,
                importance: Importance::UNIFORM,
            };
            let fitted = helpers.fitted(&training, correction.groups);
            (targets.rms(&fitted.envelope.palettes(&poses)), correction.bytes)
        };
        let (best, all) = of(usize::MAX);
        let (smaller, some) = of(all / 3);
        assert!(some <= all / 3 && best < smaller, "{best} {all} {smaller} {some}");
        let taken = search.within(all / 3).unwrap();
        for (group, &taken) in search.groups.iter().zip(&taken).filter(|(g, t)| **t < g.preferred) {
            let step = group.sizes[taken + 1].bytes - group.sizes[taken].bytes;
            assert!(some + step > all / 3, "{some} bytes leave room for {step}");
        }
        let frames = examples.frames_of(Split::HeldOut);
        let (poses, trajectories) = training.view(&examples, &frames);
        let lbs = &training.lbs.weights;
        let targets = Targets {
            rest: &training.rest,
            weights: lbs,
            trajectories: &trajectories,
            importance: Importance::UNIFORM,
        };
        let lbs = targets.rms(&poses.stacked());
        assert!(best < 0.1 * lbs && smaller < 0.3 * lbs, "{best} {smaller} {lbs}");
        assert!(search.fit(0).unwrap().bytes == 0, "no map at all takes no bytes");

        let mut still = examples.clone();
        still.transforms.fill([[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]]);
        let rest = Poses::new(&still, &[0]);
        let fitted = helpers.fitted(&training, search.fit(usize::MAX).unwrap().groups);
        let palette = fitted.envelope.palettes(&rest);
        let len = palette.ncols() / 4;
        let identity = |row: usize, column: usize| f64::from(u8::from(row % 3 == column % 4));
        let difference = palette - Mat::from_fn(3, 4 * len, identity);
        assert!(difference.norm_max() < 1e-12);
    }
}
