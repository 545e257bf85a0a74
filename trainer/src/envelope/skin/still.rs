//! Joints that keep still, and what follows them (METHOD §1.2): poses cannot tell it from what their parents move.

use super::blend::Weights;
use super::poses::Poses;
use crate::examples::Skeleton;
use nalgebra::Vector3;

/// Joints in groups that move as one in every pose, and where each has its bones.
#[derive(Default)]
pub struct Still {
    /// For each joint, the joints of its group that may be followed; none where it moves alone.
    groups: Vec<Vec<usize>>,
    bones: Vec<Vec<Bone>>,
}

/// A bone, from a joint's origin to a child's; of a joint without children as long as its parent's, on from there.
struct Bone {
    from: Vector3<f64>,
    along: Vector3<f64>,
}

impl Still {
    /// Finds them.
    ///
    /// - `poses`: with lengths in diagonals.
    /// - `skeleton`: in any unit.
    pub fn new(poses: &Poses, skeleton: &Skeleton) -> Self {
        let origins: Vec<Vector3<f64>> =
            skeleton.rest.iter().map(|frame| frame.map(|row| row[3]).into()).collect();
        let (joints, parents) = (0..origins.len(), skeleton.own_parents());
        // The joint that is the farthest up of those that move with it.
        let first = |joint: usize| {
            let carrier = |at: &usize| parents[*at].filter(|&up| poses.move_as_one(joint, up));
            std::iter::successors(Some(joint), carrier).last().unwrap_or(joint)
        };
        let firsts: Vec<usize> = joints.clone().map(first).collect();
        // Nothing tells where a joint is that neither its file nor its motion places.
        let is_placed =
            |&joint: &usize| joint == firsts[joint] || !skeleton.unplaced.contains(&joint);
        let group = |first: &usize| -> Vec<usize> {
            let all: Vec<usize> = joints.clone().filter(|&joint| firsts[joint] == *first).collect();
            if all.len() > 1 { all.into_iter().filter(is_placed).collect() } else { Vec::new() }
        };
        let bones = |joint: usize| {
            let from = origins[joint];
            let children = joints.clone().filter(|&child| parents[child] == Some(joint));
            let mut bones: Vec<Bone> =
                children.map(|child| Bone { from, along: origins[child] - from }).collect();
            if bones.is_empty() {
                let along = parents[joint].map_or_else(Vector3::zeros, |up| from - origins[up]);
                bones.push(Bone { from, along });
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
    /// - `rest`: in the unit of the skeleton.
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
        (apart - self.along * at.clamp(0.0, 1.0)).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Matrix3x4, Rotation3};

    /// Joints 0, 1 and 2 in a row, of which some turn.
    fn still(turning: &[usize]) -> Still {
        placed(turning, &[])
    }

    fn placed(turning: &[usize], unplaced: &[usize]) -> Still {
        let origins = [0.0, 1.0, 2.0].map(|x| Vector3::new(x, 0.0, 0.0));
        let rest =
            |x: &Vector3<f64>| [[1.0, 0.0, 0.0, x.x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let skeleton = Skeleton {
            names: ["a", "b", "c"].map(str::to_owned).into(),
            parents: vec![None, Some(0), Some(1)],
            rest: origins.iter().map(rest).collect(),
            roots: Vec::new(),
            unplaced: unplaced.to_vec(),
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
        Still::new(&poses, &skeleton)
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
    fn joints_that_nothing_places_are_followed_by_none() {
        let list = [(2, 0.75), (0, 0.25)];
        assert_eq!(settled(&placed(&[], &[1, 2]), 2.5, &list), [(0, 1.0)]);
        assert_eq!(settled(&placed(&[1], &[2]), 2.5, &list), [(1, 0.75), (0, 0.25)]);
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
