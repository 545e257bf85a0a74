//! Joints that keep still, and what follows them (METHOD §1.2): poses cannot tell it from what their parents move.

use super::blend::Weights;
use super::poses::Poses;
use nalgebra::Vector3;

/// Joints in groups that move as one in every pose, and where each has its bones.
#[derive(Default)]
pub struct Still {
    /// For each joint, the joints of its group; none where it moves alone.
    groups: Vec<Vec<usize>>,
    bones: Vec<Vec<Bone>>,
}

/// A bone, from a joint's origin to a child's, or on from where the parent stands.
struct Bone {
    from: Vector3<f64>,
    along: Vector3<f64>,
    /// How far it goes, in lengths of `along`.
    most: f64,
}

impl Still {
    /// Finds them.
    ///
    /// - `poses`: with lengths in diagonals.
    /// - `parents`, `origins`: of J joints, these in the rest pose and in any unit.
    pub fn new(poses: &Poses, parents: &[Option<usize>], origins: &[Vector3<f64>]) -> Self {
        let joints = 0..parents.len();
        let carrier =
            |joint: usize| parents[joint].filter(|&parent| poses.move_as_one(joint, parent));
        let first =
            |joint| std::iter::successors(Some(joint), |&j| carrier(j)).last().unwrap_or(joint);
        let firsts: Vec<usize> = joints.clone().map(first).collect();
        let group = |first: &usize| -> Vec<usize> {
            let all: Vec<usize> = joints.clone().filter(|&joint| firsts[joint] == *first).collect();
            if all.len() > 1 { all } else { Vec::new() }
        };
        let bones = |joint: usize| {
            let from = origins[joint];
            let children = joints.clone().filter(|&child| parents[child] == Some(joint));
            let mut bones: Vec<Bone> = children
                .map(|child| Bone { from, along: origins[child] - from, most: 1.0 })
                .collect();
            if bones.is_empty() {
                let along =
                    parents[joint].map_or_else(Vector3::zeros, |parent| from - origins[parent]);
                bones.push(Bone { from, along, most: f64::INFINITY });
            }
            bones
        };
        Self {
            groups: firsts.iter().map(group).collect(),
            bones: joints.clone().map(bones).collect(),
        }
    }

    /// Gives what a vertex follows of joints that move as one to the one whose bone is nearest. The poses are met as before.
    ///
    /// - `weights`: on a palette in which the joints come first.
    /// - `rest`: in the unit of the joints' origins.
    #[must_use]
    pub fn settle(&self, weights: &Weights, rest: &[[f64; 3]]) -> Weights {
        let settled = |(vertex, x): (usize, &[f64; 3])| {
            let mut list = Vec::<(usize, f64)>::new();
            for (map, weight) in weights.of(vertex) {
                let map = self.nearest(map, &Vector3::from(*x));
                match list.iter_mut().find(|own| own.0 == map) {
                    Some(own) => own.1 += weight,
                    None => list.push((map, weight)),
                }
            }
            list.sort_by(|a, b| b.1.total_cmp(&a.1));
            list
        };
        Weights::from_lists(weights.most(), rest.iter().enumerate().map(settled))
    }

    /// Returns the joint of a map's group that a point is nearest to; of a map that moves alone, that one.
    fn nearest(&self, map: usize, x: &Vector3<f64>) -> usize {
        let group = self.groups.get(map).into_iter().flatten();
        let distance = |joint: usize| {
            self.bones[joint].iter().map(|bone| bone.distance(x)).fold(f64::INFINITY, f64::min)
        };
        let distances = group.map(|&joint| (joint, distance(joint)));
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(map, |(joint, _)| joint)
    }
}

impl Bone {
    fn distance(&self, x: &Vector3<f64>) -> f64 {
        let (apart, square) = (x - self.from, self.along.norm_squared());
        let at = if square > 0.0 { apart.dot(&self.along) / square } else { 0.0 };
        (apart - self.along * at.clamp(0.0, self.most)).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::Skeleton;
    use nalgebra::{Isometry3, Matrix3x4, Rotation3};

    /// Joints 0, 1 and 2 in a row, of which some turn.
    fn still(turning: &[usize]) -> Still {
        let origins = [0.0, 1.0, 2.0].map(|x| Vector3::new(x, 0.0, 0.0));
        let rest =
            |x: &Vector3<f64>| [[1.0, 0.0, 0.0, x.x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let skeleton = Skeleton {
            names: ["a", "b", "c"].map(str::to_owned).into(),
            parents: vec![None, Some(0), Some(1)],
            rest: origins.iter().map(rest).collect(),
            roots: Vec::new(),
            unplaced: Vec::new(),
        };
        let pose = |angle: f64| -> Vec<Matrix3x4<f64>> {
            let turn = |joint: usize| if turning.contains(&joint) { angle } else { 0.0 };
            let about = |joint: usize| {
                let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turn(joint));
                let shift = origins[joint] - turn * origins[joint];
                Isometry3::from_parts(shift.into(), turn.into()).to_matrix()
            };
            let all = (0..3).scan(nalgebra::Matrix4::identity(), |map, joint| {
                *map *= about(joint);
                Some(map.fixed_rows::<3>(0).into_owned())
            });
            all.collect()
        };
        let poses = Poses::made(&[pose(0.0), pose(0.5), pose(-0.2)], &skeleton);
        Still::new(&poses, &skeleton.parents, &origins)
    }

    fn settled(still: &Still, x: f64, list: &[(usize, f64)]) -> Vec<(usize, f64)> {
        let weights = Weights::from_lists(4, std::iter::once(list.to_vec()));
        still.settle(&weights, &[[x, 0.3, 0.0]]).of(0).collect()
    }

    #[test]
    fn what_moves_as_one_follows_the_nearest_bone() {
        let none = still(&[]);
        for (x, joint) in [(-1.0, 0), (0.4, 0), (1.3, 1), (1.9, 1), (2.5, 2), (9.0, 2)] {
            assert_eq!(settled(&none, x, &[(0, 0.75), (2, 0.25)]), [(joint, 1.0)], "{x}");
        }
    }

    #[test]
    fn joints_that_turn_and_helpers_keep_what_follows_them() {
        let list = [(0, 0.5), (5, 0.25), (2, 0.25)];
        assert_eq!(settled(&still(&[1, 2]), 2.5, &list), list);
        // Joint 2 is still on joint 1, and joint 1 turns.
        assert_eq!(settled(&still(&[1]), 1.5, &list), [(0, 0.5), (5, 0.25), (1, 0.25)]);
        let list = [(1, 0.4), (0, 0.35), (2, 0.25)];
        assert_eq!(settled(&still(&[1]), 2.5, &list), [(2, 0.65), (0, 0.35)]);
        assert_eq!(settled(&still(&[2]), 0.5, &list), [(0, 0.75), (2, 0.25)]);
    }
}
