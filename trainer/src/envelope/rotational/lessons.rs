//! Lessons: made poses around those of training, and what kernel maps on helpers predict for them.
//!
//! A reconstruction extrapolates linearly, and training poses along one path say nothing of what lies beside it: its
//! refinement is free there. Kernel maps know how far they have seen and follow LBS where they have not. So the
//! refinement is fitted to them too, in poses that no one took; they count little, and decide what training leaves open.

use crate::envelope::fitted::Fitted;
use crate::envelope::skin::blend::Weights;
use crate::envelope::skin::poses::Poses;
use crate::envelope::skin::training::Training;
use crate::numeric::affine::{joined, linear};
use crate::numeric::so3;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How many poses are made.
const POSES: usize = 512;
/// Most that a pose of training is taken from rest, in its own measure.
const FARTHEST: f64 = 2.0;
/// Share of the joints that leave the path of the pose.
const ASIDE: f64 = 0.3;
/// How far such a joint is turned aside, of its RMS angle in training; and at least, in radians, for one that kept still.
const TURN: f64 = 0.5;
const LEAST_TURN: f64 = 0.3;

/// Made poses and a teacher's palettes in them, in training units.
pub struct Lessons {
    /// m poses.
    pub poses: Poses,
    /// The teacher's palettes, 3m x 4L.
    pub palettes: Mat<f64>,
    /// The vertices' weights on them.
    pub weights: Weights,
}

impl Lessons {
    /// Makes poses around those of training, and asks a teacher.
    pub fn new(training: &Training, teacher: &Fitted) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let maker = Maker::new(training);
        let poses: Vec<_> = (0..POSES).map(|_| maker.pose(&maker.motions(&mut random))).collect();
        let poses = Poses::made(&poses, &training.skeleton);
        Self {
            palettes: teacher.envelope.palettes(&poses),
            weights: teacher.weights.clone(),
            poses,
        }
    }
}

/// How a joint moves in a made pose: as in a pose of training, its motion from rest times a factor, and turned aside.
#[derive(Clone, Copy)]
struct Motion {
    frame: usize,
    factor: f64,
    /// Axis times angle, in radians.
    aside: Vector3<f64>,
}

/// What makes poses of those of training.
struct Maker<'a> {
    training: &'a Training,
    /// The joints, each after its parent.
    order: Vec<usize>,
    /// How far each is turned aside, J, in radians.
    turns: Vec<f64>,
}

impl<'a> Maker<'a> {
    fn new(training: &'a Training) -> Self {
        let Training { poses, skeleton, .. } = training;
        let parent = |joint: &usize| skeleton.parents[*joint];
        let depth = |joint: &usize| std::iter::successors(parent(joint), parent).count();
        let mut order: Vec<usize> = (0..poses.joint_len()).collect();
        order.sort_by_key(depth);
        let turn = |joint| {
            let squared = |pose| poses.angle(pose, joint).norm_squared();
            let sum: f64 = (0..poses.len()).map(squared).sum();
            (TURN * (sum / poses.len() as f64).sqrt()).max(LEAST_TURN)
        };
        Self { training, turns: (0..poses.joint_len()).map(turn).collect(), order }
    }

    /// Has the joints move as in one pose, and some of them each in its own way.
    fn motions(&self, random: &mut impl Rng) -> Vec<Motion> {
        let some = |random: &mut dyn Rng| Motion {
            frame: random.random_range(0..self.training.poses.len()),
            factor: random.random_range(0.0..FARTHEST),
            aside: Vector3::zeros(),
        };
        let whole = some(random);
        let of_joint = |turn: &f64| {
            if !random.random_bool(ASIDE) {
                return whole;
            }
            Motion { aside: self.aside(*turn, random), ..some(random) }
        };
        self.turns.iter().map(of_joint).collect()
    }

    /// A turn about axes that stand by some vertices, so that a character in other axes is turned alike.
    fn aside(&self, turn: f64, random: &mut impl Rng) -> Vector3<f64> {
        let rest = &self.training.rest;
        let mut axes = [Vector3::zeros(); 3];
        for axis in 0..3 {
            let vertex = Vector3::from(rest[random.random_range(0..rest.len())]);
            let across = axes.iter().fold(vertex, |left, axis| left - axis * axis.dot(&left));
            axes[axis] = across.try_normalize(f64::EPSILON).unwrap_or_default();
        }
        let about = |axis: usize| axes[(axis + 1) % 3].cross(&axes[(axis + 2) % 3]);
        (0..3).map(|axis| about(axis) * random.random_range(-turn..=turn)).sum()
    }

    /// The joints' maps as the root sees them, J. A joint whose origin parts from where its parent carries it, or which
    /// has a scale, does so as in the pose that it follows.
    fn pose(&self, motions: &[Motion]) -> Vec<Matrix3x4<f64>> {
        let Training { poses, skeleton, origins, .. } = self.training;
        let mut turns = vec![Matrix3::<f64>::identity(); motions.len()];
        let mut maps = vec![Matrix3x4::<f64>::identity(); motions.len()];
        for &joint in &self.order {
            let Some(parent) = skeleton.parents[joint] else { continue };
            let Motion { frame, factor, aside } = motions[joint];
            let (above, angle) = (poses.parent_rotation(frame, joint), poses.angle(frame, joint));
            let parted = poses.gap(frame, [joint, parent], &origins[joint]);
            let own = linear(poses.map(frame, joint));
            let stretch: Matrix3<f64> = (above * so3::exp(angle)).transpose() * own;
            turns[joint] = turns[parent] * so3::exp(&(angle * factor + aside));
            let at = maps[parent] * origins[joint].push(1.0)
                + turns[parent] * above.transpose() * parted * factor;
            let turned = turns[joint] * stretch;
            maps[joint] = joined(&turned, &(at - turned * origins[joint]));
        }
        maps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    #[test]
    fn joints_that_all_follow_one_pose_take_it_also_where_they_part_and_scale() {
        let options = DemoOptions { vertices: 200, poses: 8, held_out: 0, seed: 3 };
        let mut examples = demo(&options);
        let joints = examples.joint_len();
        let leaf = (0..joints).rfind(|j| !examples.skeleton.parents.contains(&Some(*j))).unwrap();
        for frame in 0..examples.frame_len() {
            let map = &mut examples.transforms[frame * joints + leaf];
            map[1][3] += 0.1 * frame as f64;
            map.iter_mut().for_each(|row| row[0] *= 1.0 + 0.05 * frame as f64);
        }
        let training = Training::new(&examples, &Silent).unwrap();
        let maker = Maker::new(&training);
        let follow = |frame, factor| {
            let motion = Motion { frame, factor, aside: Vector3::zeros() };
            maker.pose(&vec![motion; joints])
        };
        for frame in 0..training.poses.len() {
            for (made, taken) in follow(frame, 1.0).iter().zip(training.poses.pose(frame)) {
                assert!((made - taken).amax() < 1e-12, "{frame}: {made}{taken}");
            }
        }
        let still = follow(0, 0.0);
        let apart = |map: &Matrix3x4<f64>| (map - Matrix3x4::<f64>::identity()).amax();
        assert!((0..joints).all(|joint| joint == leaf || apart(&still[joint]) < 1e-12));
    }

    #[test]
    fn poses_are_the_same_in_every_fit_go_beyond_training_and_leave_its_path() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 12, held_out: 0, seed: 4 });
        let training = Training::new(&examples, &Silent).unwrap();
        let teacher = Fitted::new(&training, training.lbs.weights.clone(), None);
        let [one, other] = [(), ()].map(|()| Lessons::new(&training, &teacher));
        assert_eq!(one.palettes, other.palettes);
        assert_eq!(one.palettes, one.poses.stacked());
        let ranges = training.poses.angle_ranges();
        for (joint, beyond) in one.poses.angle_ranges().iter().enumerate().skip(1) {
            let least = (1.2 * ranges[joint]).clamp(LEAST_TURN, 3.0);
            assert!(*beyond > least, "joint {joint}: {beyond} of {}", ranges[joint]);
        }
    }
}
