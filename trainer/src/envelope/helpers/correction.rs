//! The correction: local kernel maps from the pose to what a base leaves over (METHOD §1.9).
//!
//! `T_l(q) = base_l + Q_dom K_l(φ(q))`: proxies that share a dominant joint are a group and share a
//! kernel map, which listens to the joints within some hops of that joint. Its outputs are a few
//! latent ones, the leading directions of what is left over, measured where the skin is.

use super::super::motion::Poses;
use super::super::rotational::validation::folds;
use super::candidates::{Candidates, GroupReport};
use super::features::{Input, Joints};
use crate::kernel::map::{KernelMap, Value};
use crate::progress::Progress;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4};
use rayon::prelude::*;
use std::ops::Range;

/// Name of the step.
const STEP: &str = "kernel maps";

/// What a correction is fitted to: on n training poses, the part of P proxies' transforms that a base
/// (joints, or a reconstruction) does not predict.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// n training poses.
    pub poses: &'a Poses,
    /// The joints' rest geometry.
    pub joints: Joints<'a>,
    /// Dominant joint of each of the P proxies; those of one joint stand together.
    pub dominant: &'a [usize],
    /// The transforms less those of the base, 3n x 4P.
    pub left_over: &'a Mat<f64>,
    /// The same for each fold, of a base fitted without the fold; empty where nothing of the base is
    /// fitted.
    pub without: &'a [Mat<f64>],
    /// Σ φ φᵀ over the vertices, 4P x 4P.
    pub gram: &'a Mat<f64>,
    /// V.
    pub vertices: usize,
}

/// A group's kernel map.
pub struct Group {
    /// The dominant joint that the proxies share.
    pub joint: usize,
    /// The proxies.
    pub proxies: Range<usize>,
    /// What the map listens to.
    pub inputs: Vec<Input>,
    /// The map to r latent outputs.
    pub map: KernelMap,
    /// Entries of the proxies' maps from the latent outputs, 12p x r, row 12 l + 4 r + c.
    pub outputs: Mat<f64>,
}

/// The maps of all groups, each in several sizes, before one is taken.
pub struct Search<'a> {
    target: Target<'a>,
    groups: Vec<Candidates>,
}

/// Maps that were fitted.
pub struct Correction {
    /// A map a group.
    pub groups: Vec<Group>,
    /// How each was chosen.
    pub reports: Vec<GroupReport>,
    /// What they add to the bytes of the file.
    pub bytes: usize,
    /// The correction of each training pose by maps that have not seen its fold, 3n x 4P.
    pub validated: Mat<f64>,
}

impl<'a> Search<'a> {
    /// Tries hops, kernels, widths, ridges, centres and ranks for every group.
    pub fn new(target: Target<'a>, progress: &dyn Progress) -> Self {
        let blocks = blocks(&target);
        let mut ranges = Vec::<Range<usize>>::new();
        for (l, joint) in target.dominant.iter().enumerate() {
            match ranges.last_mut() {
                Some(range) if target.dominant[range.start] == *joint => range.end = l + 1,
                _ => ranges.push(l..l + 1),
            }
        }
        progress.step(STEP, ranges.len());
        let search = |proxies| {
            let candidates = Candidates::new(&target, proxies, &blocks);
            progress.advance(1);
            candidates
        };
        let groups = ranges.into_par_iter().map(search).collect();
        Self { target, groups }
    }

    /// Takes the sizes that score best within so many bytes; none where even no map takes more.
    fn within(&self, bytes: usize) -> Option<Vec<usize>> {
        let mut taken: Vec<usize> = self.groups.iter().map(|g| g.preferred).collect();
        let sum = |taken: &[usize]| -> usize {
            self.groups.iter().zip(taken).map(|(g, &t)| g.sizes[t].bytes).sum()
        };
        while sum(&taken) > bytes {
            // The step down that costs least for what it saves.
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
        Some(taken)
    }

    /// Returns groups that correct nothing.
    pub fn nothing(&self) -> Vec<Group> {
        self.groups.iter().map(Candidates::nothing).collect()
    }

    /// Fits maps that add at most so many bytes to those of [`Search::nothing`]; none where even
    /// that is too few.
    pub fn fit(&self, bytes: usize) -> Option<Correction> {
        let taken = self.within(bytes)?;
        let Target { poses, dominant, .. } = self.target;
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
                group.add(&latents, poses, pose, &mut out.validated);
            }
            out.bytes += report.bytes;
            out.groups.push(group);
            out.reports.push(report);
        }
        Some(out)
    }
}

/// Predicts the correction of n poses, 3n x 4P.
pub fn predict(groups: &[Group], poses: &Poses, joints: Joints<'_>) -> Mat<f64> {
    let count = groups.iter().map(|group| group.proxies.len()).sum::<usize>();
    let mut out = Mat::zeros(3 * poses.len(), 4 * count);
    for group in groups {
        let inputs = joints.evaluate(poses, &group.inputs);
        for pose in 0..poses.len() {
            let Value { outputs, confidence } = group.map.evaluate(inputs.col_as_slice(pose));
            let latents: Vec<f64> = outputs.iter().map(|z| confidence * z).collect();
            group.add(&latents, poses, pose, &mut out);
        }
    }
    out
}

impl Group {
    /// Adds `Q_dom K` of latent outputs to a pose's row of maps.
    fn add(&self, latents: &[f64], poses: &Poses, pose: usize, out: &mut Mat<f64>) {
        let turn: Matrix3<f64> = poses.map(pose, self.joint).fixed_columns::<3>(0).into();
        for (k, proxy) in self.proxies.clone().enumerate() {
            let local = Matrix3x4::from_fn(|r, c| {
                let row = self.outputs.row(12 * k + 4 * r + c);
                row.iter().zip(latents).map(|(a, z)| a * z).sum::<f64>()
            });
            let added = turn * local;
            for c in 0..4 {
                for r in 0..3 {
                    out[(3 * pose + r, 4 * proxy + c)] += added[(r, c)];
                }
            }
        }
    }
}

/// Returns the folds of the cross-validation. Where the base is the same for all of them, further folds
/// that lie halfway between two are added: more folds choose better.
fn blocks(target: &Target<'_>) -> Vec<Range<usize>> {
    let mut blocks = folds(target.poses.len());
    if target.without.is_empty() {
        let between = |pair: &[Range<usize>]| {
            let middle = |block: &Range<usize>| (block.start + block.end) / 2;
            middle(&pair[0])..middle(&pair[1])
        };
        blocks.extend(blocks.windows(2).map(between).collect::<Vec<_>>());
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::super::fit;
    use super::*;
    use crate::demo::{DemoOptions, demo};
    use crate::envelope::rotational::validation::Targets;
    use crate::envelope::training::Training;
    use crate::examples::Importance;
    use crate::examples::Split;
    use crate::progress::Silent;

    #[test]
    fn poses_that_were_not_seen_come_near_rest_is_exact_and_bytes_are_kept() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 80, held_out: 20, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let helpers = fit::fit(&training, 20, 4).unwrap();
        let search = Search::new(helpers.target(&training), &Silent);
        let of = |bytes| -> (f64, usize) {
            let correction = search.fit(bytes).unwrap();
            let frames = examples.frames_of(Split::HeldOut);
            let (poses, moved) = training.view(&examples, &frames);
            let rest = &training.rest;
            let targets = Targets {
                rest,
                weights: &helpers.weights,
                trajectories: &moved,
                importance: Importance::ALIKE,
            };
            let joints = poses.stacked();
            let added = predict(&correction.groups, &poses, training.joints());
            let maps = fit::bases(&joints, &helpers.dominant) + added;
            (targets.rms(&faer::concat![[joints, maps]]), correction.bytes)
        };
        let (best, all) = of(usize::MAX);
        let (smaller, some) = of(all / 3);
        assert!(some <= all / 3 && best < smaller, "{best} {all} {smaller} {some}");
        let frames = examples.frames_of(Split::HeldOut);
        let (poses, moved) = training.view(&examples, &frames);
        let lbs = &training.lbs.weights;
        let targets = Targets {
            rest: &training.rest,
            weights: lbs,
            trajectories: &moved,
            importance: Importance::ALIKE,
        };
        let lbs = targets.rms(&poses.stacked());
        assert!(best < 0.1 * lbs && smaller < 0.3 * lbs, "{best} {smaller} {lbs}");
        assert!(search.fit(0).unwrap().bytes == 0, "no map at all takes no bytes");

        let mut still = examples.clone();
        still.transforms.fill([[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]]);
        let rest = Poses::new(&still, &[0]);
        let groups = search.fit(usize::MAX).unwrap().groups;
        assert!(predict(&groups, &rest, training.joints()).norm_max() < 1e-12);
    }

    #[test]
    fn blocks_between_folds_overlap_two() {
        let folds = folds(40);
        assert_eq!(folds.len(), 10);
        let between = |pair: &[Range<usize>]| (pair[0].start + 2)..(pair[1].start + 2);
        let expected: Vec<_> = folds.windows(2).map(between).collect();
        let examples = demo(&DemoOptions { vertices: 200, poses: 40, held_out: 0, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let helpers = fit::fit(&training, 4, 4).unwrap();
        let target = helpers.target(&training);
        assert_eq!(blocks(&target)[10..], expected);
        let base = [Mat::zeros(120, 16)];
        assert_eq!(blocks(&Target { without: &base, ..target }), folds);
    }
}
