//! Poses without those that repeat them: a walk that is looped, a frame that is held, a pose that is come back to.
//!
//! A fit that has seen a pose knows its repeats: left out one without the other they would prove nothing.

use super::poses::Poses;
use crate::kernel::outputs::Block;
use std::ops::Range;

/// Poses are one where no joint differs by more than this share of how far joints move: what export leaves of a loop.
const SAME: f64 = 1e-3;
/// Frames on either side of a block that a fit without it does not see either.
const GAP: usize = 3;

/// Poses, those that are one together.
pub struct Distinct<'a> {
    /// The poses.
    pub poses: &'a Poses,
    /// The numbers of those that are one, in order; in the order of the first.
    groups: Vec<Vec<usize>>,
    /// Of which group each pose is, n.
    of: Vec<usize>,
}

impl<'a> Distinct<'a> {
    /// Finds poses that are one: those that are near the first of them. Where all are, each is its own.
    pub fn new(poses: &'a Poses) -> Self {
        let most = SAME * poses.farthest_apart();
        let mut groups = Vec::<Vec<usize>>::new();
        for pose in 0..poses.len() {
            match groups.iter_mut().find(|group| poses.are_alike(group[0], pose, most)) {
                Some(group) => group.push(pose),
                None => groups.push(vec![pose]),
            }
        }
        if groups.len() == 1 {
            groups = (0..poses.len()).map(|pose| vec![pose]).collect();
        }
        let mut of = vec![0; poses.len()];
        for (number, group) in groups.iter().enumerate() {
            group.iter().for_each(|&pose| of[pose] = number);
        }
        Self { poses, groups, of }
    }

    /// Counts them.
    pub fn count(&self) -> usize {
        self.groups.len()
    }

    /// Counts the poses before each of them, and all.
    pub fn starts(&self) -> Vec<usize> {
        let sizes = self.groups.iter().map(Vec::len);
        let sum = sizes.scan(0, |sum, size| {
            *sum += size;
            Some(*sum)
        });
        std::iter::once(0).chain(sum).collect()
    }

    /// Whether a clip ends before one of them.
    pub fn is_cut(&self, at: usize) -> bool {
        let clip = |at: usize| self.poses.times()[self.groups[at][0]].clip;
        at > 0 && clip(at - 1) != clip(at)
    }

    /// A block of some in a row, and near it their neighbours in time.
    pub fn run(&self, range: Range<usize>) -> Block {
        let gap = GAP.min(range.len() / 2);
        let times = |at: usize| self.groups[at].iter().map(|&pose| self.poses.times()[pose]);
        let is_near = |a: usize, b: usize| {
            times(a).any(|a| times(b).any(|b| a.clip == b.clip && a.frame.abs_diff(b.frame) <= gap))
        };
        let (first, last) = (range.start, range.end - 1);
        let before = (0..first).rev().take_while(|&at| is_near(at, first)).count();
        let after = (range.end..self.count()).take_while(|&at| is_near(at, last)).count();
        let near = [first - before..first, range.end..range.end + after];
        Block { own: self.poses_of(range), near: self.poses_of(near.into_iter().flatten()) }
    }

    /// A block of some poses, and near it those that repeat them.
    pub fn block(&self, own: Vec<usize>) -> Block {
        let mut groups: Vec<usize> = own.iter().map(|&pose| self.of[pose]).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut near = self.poses_of(groups.into_iter());
        near.retain(|pose| !own.contains(pose));
        Block { own, near }
    }

    /// Lists the poses of some of the groups.
    fn poses_of(&self, groups: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut poses: Vec<usize> = groups.flat_map(|at| &self.groups[at]).copied().collect();
        poses.sort_unstable();
        poses
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{looped, moving};
    use super::*;

    #[test]
    fn neighbours_of_a_block_are_left_out_with_it() {
        let out = |poses: &Poses, range: Range<usize>| {
            let Block { own, near } = Distinct::new(poses).run(range.clone());
            assert_eq!(own, Vec::from_iter(range));
            near
        };
        let clips = moving(&[20, 30]);
        assert_eq!(out(&clips, 5..12), [2, 3, 4, 12, 13, 14]);
        assert_eq!(out(&clips, 2..4), [1, 4], "few poses have few neighbours");
        assert_eq!(out(&clips, 20..30), [30, 31, 32], "not across clips");
        let apart: Vec<usize> = (0..15).chain(24..40).collect();
        assert_eq!(out(&clips.only(&apart), 5..15), [2, 3, 4], "nor where frames are missing");
    }

    #[test]
    fn repeats_are_left_out_together() {
        let poses = looped(12, 3);
        let distinct = Distinct::new(&poses);
        assert_eq!(distinct.count(), 12);
        let Block { own, near } = distinct.run(4..6);
        assert_eq!(own, [4, 5, 16, 17, 28, 29]);
        assert_eq!(near, [3, 6, 15, 18, 27, 30]);
        assert_eq!(distinct.block(vec![5, 17, 6]).near, [18, 29, 30]);
    }

    #[test]
    fn where_all_poses_are_one_each_is_its_own() {
        assert_eq!(Distinct::new(&looped(1, 9)).count(), 9);
    }
}
