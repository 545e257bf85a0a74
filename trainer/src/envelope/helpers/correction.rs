//! The helpers' prediction: local kernel maps from pose features (METHOD §1.9).
//!
//! `T_l(q) = B_dom + Q_dom K_l(φ(q))`: helpers that share a dominant joint share a kernel map, which
//! listens to the joints within some hops of that joint.

use super::super::motion::Poses;
use super::super::rotational::validation::folds;
use super::fit::{Helpers, in_joint_frame, map_of, set_map};
use crate::kernel::ridge::{Choice, KernelMap};
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Weight of a displacement, in diagonals, against a rotation's entries.
const DISPLACEMENT: f64 = 3.0;
/// Displacements that spread less than this (RMS, in weighted diagonals) are left out.
const STILL: f64 = 3e-4;

/// The joints' rest geometry, as the features see it.
pub struct Joints<'a> {
    /// Parent of each joint.
    pub parents: &'a [Option<usize>],
    /// Rest origin of each joint, as the training sees it.
    pub origins: &'a [Vector3<f64>],
}

/// Kernel maps of all groups of helpers.
pub struct Correction<'a> {
    joints: Joints<'a>,
    groups: Vec<Group>,
}

struct Group {
    /// The dominant joint that the helpers share.
    joint: usize,
    helpers: Vec<usize>,
    listens: Vec<Listener>,
    map: Option<KernelMap>,
    /// The map's value in the rest pose, which is subtracted.
    rest: Vec<f64>,
}

/// A joint that a group listens to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Listener {
    joint: usize,
    /// Whether it moves against its parent, not only turns.
    moves: bool,
}

impl<'a> Correction<'a> {
    /// Fits the maps of helpers to the training poses; a group listens to the joints within `hops`
    /// of its dominant joint.
    pub fn fit(helpers: &Helpers, poses: &Poses, joints: Joints<'a>, hops: usize) -> Self {
        let mut by_joint = BTreeMap::<usize, Vec<usize>>::new();
        for (l, &joint) in helpers.dominant.iter().enumerate() {
            by_joint.entry(joint).or_default().push(l);
        }
        let blocks = folds(poses.len());
        let groups = by_joint.into_par_iter().map(|(joint, members)| {
            let listens: Vec<_> = near(joints.parents, joint, hops)
                .into_iter()
                .map(|joint| Listener { joint, moves: joints.moves(poses, joint) })
                .collect();
            let inputs: Vec<_> =
                (0..poses.len()).map(|i| joints.features(poses, i, &listens)).collect();
            let width = inputs.first().map_or(0, Vec::len);
            let inputs = Mat::from_fn(width, poses.len(), |r, i| inputs[i][r]);
            let outputs = Mat::from_fn(poses.len(), 12 * members.len(), |i, o| {
                let map = map_of(&helpers.maps, i, members[o / 12]);
                in_joint_frame(poses, i, joint, &map)[o % 12]
            });
            let map = KernelMap::fit(&inputs, &outputs, &blocks);
            // Every feature is zero in the rest pose.
            let rest = map.as_ref().map_or_else(Vec::new, |map| map.evaluate(&vec![0.0; width]));
            Group { joint, helpers: members, listens, map, rest }
        });
        let groups = groups.collect();
        Self { joints, groups }
    }

    /// Predicts the helpers' maps of n poses, 3n x 4P.
    pub fn predict(&self, poses: &Poses) -> Mat<f64> {
        let count = self.groups.iter().map(|group| group.helpers.len()).sum::<usize>();
        let mut maps = Mat::zeros(3 * poses.len(), 4 * count);
        for group in &self.groups {
            for pose in 0..poses.len() {
                let base = poses.map(pose, group.joint);
                let phi = self.joints.features(poses, pose, &group.listens);
                let out = group.map.as_ref().map(|map| map.evaluate(&phi));
                for (k, &helper) in group.helpers.iter().enumerate() {
                    let added = out.as_ref().map_or_else(Matrix3x4::zeros, |out| {
                        Matrix3x4::from_fn(|r, c| {
                            let o = 12 * k + 3 * c + r;
                            out[o] - group.rest[o]
                        })
                    });
                    let map = base + base.fixed_columns::<3>(0) * added;
                    set_map(&mut maps, pose, helper, &map);
                }
            }
        }
        maps
    }

    /// The width and ridge of each group's map.
    pub fn choices(&self) -> impl Iterator<Item = (usize, Choice)> + '_ {
        self.groups.iter().filter_map(|g| g.map.as_ref().map(|map| (g.joint, map.choice)))
    }
}

impl Joints<'_> {
    /// Relative rotations minus I, and displacements of the origins in their parents' frames.
    fn features(&self, poses: &Poses, pose: usize, listens: &[Listener]) -> Vec<f64> {
        let mut out = Vec::with_capacity(12 * listens.len());
        for listener in listens {
            let parent = poses.parent_rotation(pose, listener.joint);
            let own: Matrix3<f64> = poses.map(pose, listener.joint).fixed_columns::<3>(0).into();
            out.extend((parent.transpose() * own - Matrix3::identity()).iter());
            if listener.moves {
                out.extend(self.displacement(poses, pose, listener.joint).iter());
            }
        }
        out
    }

    fn displacement(&self, poses: &Poses, pose: usize, joint: usize) -> Vector3<f64> {
        let Some(parent) = self.parents[joint] else { return Vector3::zeros() };
        let at = |j: usize| poses.map(pose, j) * self.origins[j].push(1.0);
        let apart = poses.parent_rotation(pose, joint).transpose() * (at(joint) - at(parent));
        (apart - (self.origins[joint] - self.origins[parent])) * DISPLACEMENT
    }

    /// Tells whether a joint moves against its parent over the training poses.
    fn moves(&self, poses: &Poses, joint: usize) -> bool {
        let all: Vec<_> =
            (0..poses.len()).map(|pose| self.displacement(poses, pose, joint)).collect();
        let mean = all.iter().sum::<Vector3<f64>>() / all.len().max(1) as f64;
        let spread = all.iter().map(|d| (d - mean).component_mul(&(d - mean)));
        (spread.sum::<Vector3<f64>>() / all.len().max(1) as f64).max().sqrt() > STILL
    }
}

/// Joints within some hops of a joint, the root left out; all of them where that leaves none.
fn near(parents: &[Option<usize>], joint: usize, hops: usize) -> Vec<usize> {
    let mut found = vec![false; parents.len()];
    found[joint] = true;
    for _ in 0..hops {
        let last = found.clone();
        for (child, parent) in parents.iter().enumerate() {
            if let Some(parent) = *parent {
                found[child] |= last[parent];
                found[parent] |= last[child];
            }
        }
    }
    let turning = |j: &usize| parents[*j].is_some();
    let listens: Vec<usize> = (0..parents.len()).filter(|j| found[*j] && turning(j)).collect();
    if listens.is_empty() { (0..parents.len()).filter(turning).collect() } else { listens }
}

#[cfg(test)]
mod tests {
    use super::super::fit;
    use super::*;
    use crate::demo::{DemoOptions, demo};
    use crate::envelope::rotational::training::Training;
    use crate::envelope::rotational::validation::Targets;
    use crate::envelope::weights;
    use crate::examples::Split;

    #[test]
    fn hops_run_along_the_tree_both_ways() {
        let chain = [None, Some(0), Some(1), Some(2), Some(1)];
        assert_eq!(near(&chain, 2, 1), [1, 2, 3]);
        assert_eq!(near(&chain, 2, 2), [1, 2, 3, 4]);
        assert_eq!(near(&chain, 0, 0), [1, 2, 3, 4], "the root alone hears nothing");
    }

    #[test]
    fn poses_that_were_not_seen_come_near_and_rest_is_exact() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 80, held_out: 20, seed: 1 });
        let training = Training::new(&examples).unwrap();
        let (rest, poses) = (&training.rest, &training.poses);
        let (lbs, errors) = weights::fit(rest, &training.trajectories, poses, 4);
        let helpers = fit::fit(&training, (&lbs, &errors), 20, 4).unwrap();
        let origins = training.origins(&examples);
        let joints = Joints { parents: &examples.skeleton.parents, origins: &origins };
        let correction = Correction::fit(&helpers, poses, joints, 2);

        let frames = examples.frames_of(Split::HeldOut);
        let (poses, moved) = training.view(&examples, &frames);
        let stacked = poses.stacked();
        let of = |weights| Targets { rest, weights, trajectories: &moved };
        let palette = faer::concat![[&stacked, &correction.predict(&poses)]];
        let (model, lbs) = (of(&helpers.weights).rms(&palette), of(&lbs).rms(&stacked));
        assert!(model < 0.15 * lbs, "{model} against {lbs} of LBS");

        let mut still = examples.clone();
        still.transforms.fill([[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]]);
        let predicted = correction.predict(&Poses::new(&still, &[0]));
        let identity = |r: usize, c: usize| f64::from(u8::from(r == c % 4));
        let rest = Mat::from_fn(3, predicted.ncols(), identity);
        assert!((predicted - rest).norm_max() < 1e-12);
        assert!(correction.choices().count() > 1);
    }
}
