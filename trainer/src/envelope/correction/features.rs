//! Pose features, the inputs of kernel maps (METHOD §1.9).

use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::training::Training;
use crate::envelope::model::{Feature, Input};
use crate::numeric::so3;
use crate::settings::Settings;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use sinew_runtime::envelope::STRAIN_LEN;

/// Smallest RMS spread of a curve, or of an entry of a rotation or of a strain, that becomes an input.
const CONSTANT: f64 = 1e-5;

/// Rest geometry of the joints, for computing features.
#[derive(Clone, Copy)]
pub struct Features<'a> {
    /// Parent of each joint.
    pub parents: &'a [Option<usize>],
    /// Rest origin of each joint, in training units.
    pub origins: &'a [Vector3<f64>],
    /// Settings of the fit.
    pub settings: &'a Settings,
}

impl<'a> Features<'a> {
    /// Uses the joints of a training.
    pub fn of(training: &'a Training<'a>) -> Self {
        let Training { skeleton, origins, settings, .. } = training;
        Self { parents: &skeleton.parents, origins, settings }
    }

    /// Lists the features of some joints that vary over the poses.
    pub fn inputs(&self, poses: &Poses, joints: &[usize]) -> Vec<Input> {
        let Settings { displacement, displacement_min, strain, .. } = *self.settings;
        let mut inputs = Vec::new();
        for &joint in joints {
            let entries: Vec<_> =
                (0..poses.len()).map(|i| self.joint_features(poses, i, joint)).collect();
            let spread = |entry: usize| spread(entries.iter().map(|all| all[entry]));
            let moves = [3, 7, 11].map(|entry| displacement * spread(entry)).into_iter();
            let moves = moves.fold(0.0, f64::max) > displacement_min;
            let of_joint = (0..12).filter_map(|entry| {
                let feature = Feature::Joint { joint, entry };
                let (varies, weight) = match feature.is_length() {
                    true => (moves, displacement),
                    false => (spread(entry) > CONSTANT, 1.0),
                };
                varies.then_some(Input { feature, weight })
            });
            inputs.extend(of_joint);
            if poses.stretch() {
                let of_strain =
                    |entry: usize| (0..poses.len()).map(move |i| poses.strain(i, joint)[entry]);
                let varying =
                    (0..STRAIN_LEN).filter(|&entry| self::spread(of_strain(entry)) > CONSTANT);
                let input =
                    |entry| Input { feature: Feature::Strain { joint, entry }, weight: strain };
                inputs.extend(varying.map(input));
            }
        }
        inputs
    }

    /// Lists the curves that vary over the poses, weighted so that all have one spread.
    pub fn curves(&self, poses: &Poses) -> Vec<Input> {
        let input = |curve: usize| {
            let spread = spread((0..poses.len()).map(|i| poses.curves(i)[curve]));
            let (feature, weight) = (Feature::Curve(curve), self.settings.curve / spread);
            (spread > CONSTANT).then_some(Input { feature, weight })
        };
        (0..poses.curve_len()).filter_map(input).collect()
    }

    /// Evaluates inputs in all poses, d x n.
    pub fn evaluate(&self, poses: &Poses, inputs: &[Input]) -> Mat<f64> {
        let mut out = Mat::zeros(inputs.len(), poses.len());
        for pose in 0..poses.len() {
            let mut last = None;
            for (row, input) in inputs.iter().enumerate() {
                let value = match input.feature {
                    Feature::Curve(curve) => poses.curves(pose)[curve],
                    Feature::Strain { joint, entry } => poses.strain(pose, joint)[entry],
                    Feature::Joint { joint, entry } => {
                        let known = last.filter(|(known, _)| *known == joint);
                        let features = known.map_or_else(
                            || self.joint_features(poses, pose, joint),
                            |known| known.1,
                        );
                        last = Some((joint, features));
                        features[entry]
                    }
                };
                out[(row, pose)] = input.weight * value;
            }
        }
        out
    }

    /// Computes the features of a joint: half of the rotation relative to the parent ([`so3::half`]) and, last in each
    /// row, the gap between the joint's origin and where the parent carries it, in the parent's frame. The root's
    /// features are 0.
    fn joint_features(&self, poses: &Poses, pose: usize, joint: usize) -> [f64; 12] {
        let (turn, gap) = self.relative(poses, pose, joint);
        let turn = so3::half(&turn);
        std::array::from_fn(|k| match (k / 4, k % 4) {
            (r, 3) => gap[r],
            (r, c) => turn[(r, c)],
        })
    }

    /// Computes the rotation of a joint relative to its parent, and the gap between the joint's origin and where the
    /// parent carries it, in the parent's frame. The root has the identity and zero.
    pub fn relative(
        &self,
        poses: &Poses,
        pose: usize,
        joint: usize,
    ) -> (Matrix3<f64>, Vector3<f64>) {
        let Some(parent) = self.parents[joint] else {
            return (Matrix3::identity(), Vector3::zeros());
        };
        let gap = poses.gap_at_parent(pose, [joint, parent], &self.origins[joint]);
        (so3::exp(poses.angle(pose, joint)), gap)
    }
}

/// Returns the RMS distance of numbers from their mean.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Lists the joints within some hops of a joint, without the root. If none are left, lists all joints but the root.
pub fn near(parents: &[Option<usize>], joint: usize, hops: usize) -> Vec<usize> {
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
    let near: Vec<usize> = (0..parents.len()).filter(|j| found[*j] && turning(j)).collect();
    if near.is_empty() { (0..parents.len()).filter(turning).collect() } else { near }
}

/// Selects the joints on one side of a joint: the joint itself, and those behind one of its neighbours in the tree.
pub fn on_side(
    parents: &[Option<usize>],
    joint: usize,
    neighbour: usize,
    joints: &[usize],
) -> Vec<usize> {
    let below = |mut at: usize| loop {
        match parents[at] {
            Some(parent) if parent == joint => break Some(at),
            Some(parent) => at = parent,
            None => break None,
        }
    };
    let side = |at: usize| below(at).or(parents[joint]);
    let is_own = |&at: &usize| at == joint || side(at) == Some(neighbour);
    joints.iter().copied().filter(is_own).collect()
}

/// Lists the neighbours of a joint in the tree.
pub fn neighbours(parents: &[Option<usize>], joint: usize) -> impl Iterator<Item = usize> + '_ {
    let children = (0..parents.len()).filter(move |&child| parents[child] == Some(joint));
    children.chain(parents[joint])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::demo::{DemoOptions, demo};

    #[test]
    fn hops_run_along_the_tree_both_ways() {
        let chain = [None, Some(0), Some(1), Some(2), Some(1)];
        assert_eq!(near(&chain, 2, 1), [1, 2, 3]);
        assert_eq!(near(&chain, 2, 2), [1, 2, 3, 4]);
        assert_eq!(near(&chain, 0, 0), [1, 2, 3, 4], "the root alone has no input");
    }

    #[test]
    fn a_side_has_the_joints_behind_a_neighbour() {
        let chain = [None, Some(0), Some(1), Some(2), Some(1)];
        let all = [0, 1, 2, 3, 4];
        let side = |neighbour| on_side(&chain, 1, neighbour, &all);
        assert_eq!(neighbours(&chain, 1).collect::<Vec<_>>(), [2, 4, 0]);
        assert_eq!([side(2), side(4), side(0)], [vec![1, 2, 3], vec![1, 4], vec![0, 1]]);
    }

    #[test]
    fn constant_features_are_no_inputs() {
        let mut examples = demo(&DemoOptions { vertices: 200, poses: 12, held_out: 0, seed: 3 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let inputs = |examples: &crate::examples::Examples| {
            let origins: Vec<_> = examples
                .skeleton
                .rest
                .iter()
                .map(|m| Vector3::new(m[0][3], m[1][3], m[2][3]))
                .collect();
            let joints = Features {
                parents: &examples.skeleton.parents,
                origins: &origins,
                settings: &Settings::default(),
            };
            let near = near(joints.parents, examples.skeleton.root(), 9);
            joints.inputs(&Poses::new(examples, &frames), &near)
        };
        assert!(inputs(&examples).len() > 9);
        examples.transforms.fill([
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ]);
        assert!(inputs(&examples).is_empty());
    }
}
