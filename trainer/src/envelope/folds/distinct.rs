//! Repeated poses, for example of a looped walk or a held frame.
//!
//! A fit to a pose also knows its repeats, so repeats are left out together.

use crate::envelope::lbs::poses::{Poses, Time};
use crate::regression::outputs::Block;
use std::ops::Range;

/// Two poses repeat each other if no entry of a joint's map differs by more than this share of the motion's size, and no
/// curve by more than this share of its range.
/// Export leaves such differences in a loop.
const REPEAT: f64 = 1e-3;
/// Largest size of the motion: the entries of two rotations differ by 2 at most.
const LARGEST: f64 = 2.0;
/// Frames on either side of a block that are left out with it.
const GAP: usize = 3;

/// Poses in groups of repeats.
pub(super) struct Distinct {
    /// Clip and frame of each of the n poses.
    pub(super) times: Vec<Time>,
    /// Pose numbers of each group, ascending; groups in the order of their first pose.
    groups: Vec<Vec<usize>>,
    /// Group of each pose, n.
    of: Vec<usize>,
}

impl Distinct {
    /// Groups the poses that repeat the first pose of a group. If all poses are equal, each pose gets its own group.
    pub(super) fn new(poses: &Poses) -> Self {
        let most = REPEAT * poses.largest_difference().min(LARGEST);
        let mut groups = Vec::<Vec<usize>>::new();
        for pose in 0..poses.len() {
            match groups.iter_mut().find(|group| poses.are_close(group[0], pose, (most, REPEAT))) {
                Some(group) => group.push(pose),
                None => groups.push(vec![pose]),
            }
        }
        if groups.len() == 1 || poses.are_equal() {
            groups = (0..poses.len()).map(|pose| vec![pose]).collect();
        }
        let mut of = vec![0; poses.len()];
        for (number, group) in groups.iter().enumerate() {
            group.iter().for_each(|&pose| of[pose] = number);
        }
        Self { times: poses.times().to_vec(), groups, of }
    }

    /// Counts the groups.
    pub(super) fn count(&self) -> usize {
        self.groups.len()
    }

    /// Counts the poses before each group, and last all poses.
    pub(super) fn starts(&self) -> Vec<usize> {
        let sizes = self.groups.iter().map(Vec::len);
        let sum = sizes.scan(0, |sum, size| {
            *sum += size;
            Some(*sum)
        });
        std::iter::once(0).chain(sum).collect()
    }

    /// Returns whether a clip ends before a group.
    pub(super) fn is_cut(&self, at: usize) -> bool {
        let clip = |at: usize| self.times[self.groups[at][0]].clip;
        at > 0 && clip(at - 1) != clip(at)
    }

    /// Creates a block of consecutive groups. The neighbours in time and their repeats are left out with the block: at
    /// most as many poses as the block has, and at most half of the other poses.
    pub(super) fn run(&self, range: Range<usize>) -> Block {
        let own = self.poses_of(range.clone());
        let most = own.len().min((self.of.len() - own.len()) / 2);
        let near = |gap| self.with_repeats(own.iter().flat_map(|&pose| self.neighbours(pose, gap)));
        let gaps = (0..=GAP.min(range.len() / 2)).rev();
        let near = gaps.map(|gap| without(near(gap), &own)).find(|near| near.len() <= most);
        Block { near: near.unwrap_or_default(), own }
    }

    /// Creates a block of poses, given in order. Repeats of the poses are left out with the block.
    pub(super) fn block(&self, own: Vec<usize>) -> Block {
        Block { near: without(self.with_repeats(own.iter().copied()), &own), own }
    }

    /// Lists the poses of a pose's clip that are at most `gap` frames from it.
    fn neighbours(&self, pose: usize, gap: usize) -> impl Iterator<Item = usize> {
        let times = &self.times;
        let own = times[pose];
        let is_near = move |other: &usize| {
            times[*other].clip == own.clip && times[*other].frame.abs_diff(own.frame) <= gap
        };
        let before = (0..pose).rev().take_while(is_near);
        before.chain((pose + 1..times.len()).take_while(is_near))
    }

    /// Lists poses and their repeats, in order.
    fn with_repeats(&self, poses: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut groups: Vec<usize> = poses.map(|pose| self.of[pose]).collect();
        groups.sort_unstable();
        groups.dedup();
        self.poses_of(groups.into_iter())
    }

    /// Lists the poses of some of the groups, in order.
    pub(super) fn poses_of(&self, groups: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut poses: Vec<usize> = groups.flat_map(|at| &self.groups[at]).copied().collect();
        poses.sort_unstable();
        poses
    }
}

/// Removes poses that are among others, given in order.
fn without(mut poses: Vec<usize>, others: &[usize]) -> Vec<usize> {
    poses.retain(|pose| others.binary_search(pose).is_err());
    poses
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Folds;
    use super::*;
    use crate::examples::testing::triangle;

    /// Makes clips of the given lengths, in which no pose repeats another.
    pub(in super::super) fn moving(clips: &[usize]) -> Poses {
        placed(clips, |pose| pose)
    }

    /// Makes one clip that plays a loop of poses several times.
    pub(in super::super) fn looped(poses: usize, times: usize) -> Poses {
        placed(&[times * poses], |pose| pose % poses)
    }

    /// Makes clips in which the place of a joint depends on a number of each frame. Different numbers give distant
    /// places.
    fn placed(clips: &[usize], number: impl Fn(usize) -> usize) -> Poses {
        let frames: Vec<usize> = (0..clips.iter().sum()).collect();
        let mut examples = triangle(frames.len());
        examples.clip_starts = (0..clips.len()).map(|clip| clips[..clip].iter().sum()).collect();
        for &frame in &frames {
            let map = &mut examples.transforms[2 * frame + 1];
            let place = [0.8192, 0.6711, 0.5497].map(|step| step * number(frame) as f64);
            (0..3).for_each(|axis| map[axis][3] = place[axis].fract());
        }
        Poses::new(&examples, &frames)
    }

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
        assert_eq!(distinct.run(10..12).near, [0, 9, 12, 21, 24, 33], "the loop begins anew");
        assert_eq!(distinct.block(vec![5, 6, 17]).near, [18, 29, 30]);
    }

    #[test]
    fn some_poses_are_always_left_for_the_fit() {
        let held: Vec<usize> = [0; 90].into_iter().chain(1..5).collect();
        let few = (2..7).flat_map(|poses| (2..5).map(move |times| looped(poses, times)));
        for poses in few.chain([moving(&[5]).only(&held)]) {
            let folds = Folds::new(&poses).runs().to_vec();
            assert!(folds.len() > 1);
            for fold in folds {
                assert!(!fold.others(poses.len()).is_empty(), "{fold:?} of {}", poses.len());
            }
        }
    }

    #[test]
    fn equal_poses_are_groups_of_one() {
        assert_eq!(Distinct::new(&looped(1, 9)).count(), 9);
    }
}
