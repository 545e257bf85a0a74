//! Blocks of training frames that are left out together (METHOD §1.9), for every choice of the fit.
//!
//! Neighbouring frames of an animation are almost equal poses. A fit without a single frame therefore proves nothing.
//! So whole blocks are left out: runs of frames with gaps around them, clips, or the ends of joints' ranges. Repeats of
//! a pose are always left out together.

mod distinct;

use crate::envelope::lbs::poses::{MIN_POSES, Poses};
use crate::regression::outputs::Block;
use distinct::Distinct;
use std::ops::Range;

/// Largest number of runs of the training poses.
const RUNS: usize = 10;
/// Smallest number of poses of a run or a part. A single pose would be a neighbour of the remaining poses.
const RUN_LEN: usize = 2;
/// Largest number of parts of a run.
const PARTS: usize = 4;
/// Smallest number of stretches of poses for a forecast.
const STRETCHES: usize = 5;
/// Smallest range of a joint's angle, in radians. Joints with a smaller range give no block.
const STILL: f64 = 0.03;

/// Blocks of training poses that are left out together.
pub struct Folds {
    distinct: Distinct,
    /// Number of runs. The runs come first in `overlapping`.
    run_len: usize,
    overlapping: Vec<Block>,
    parts: Vec<Block>,
}

impl Folds {
    /// Finds repeats and cuts poses into runs.
    pub fn new(poses: &Poses) -> Self {
        let distinct = Distinct::new(poses);
        let runs = ranges(&distinct);
        let middle = |run: &Range<usize>| (run.start + run.end) / 2;
        let across = runs.windows(2).map(|pair| middle(&pair[0])..middle(&pair[1]));
        let parts = |run: &Range<usize>| {
            let (start, len) = (run.start, run.len());
            let count = (len / RUN_LEN).clamp(1, PARTS);
            let cut = move |part: usize| start + part * len / count;
            (0..count).map(move |part| cut(part)..cut(part + 1))
        };
        let block = |range: Range<usize>| distinct.run(range);
        Self {
            run_len: runs.len(),
            overlapping: runs.iter().cloned().chain(across).map(block).collect(),
            parts: runs.iter().flat_map(parts).map(block).collect(),
            distinct,
        }
    }

    /// Returns at least two runs, which cover all poses.
    pub fn runs(&self) -> &[Block] {
        &self.overlapping[..self.run_len]
    }

    /// Returns the runs, and a further run across each border between two runs. More blocks choose better.
    pub fn overlapping(&self) -> &[Block] {
        &self.overlapping
    }

    /// Returns the parts of the runs. The final model is fitted to all poses, so fits without a whole run have larger
    /// errors than the model itself.
    pub fn parts(&self) -> &[Block] {
        &self.parts
    }

    /// Lists blocks that test extrapolation: for each of some joints, the poses with the largest rotations.
    ///
    /// - `share`: share of the poses in a block.
    pub fn range_ends(&self, poses: &Poses, joints: &[usize], share: f64) -> Vec<Block> {
        let count = (share * poses.len() as f64) as usize;
        let end = |&joint: &usize| {
            let angle = |pose: usize| poses.angle(pose, joint).norm();
            let mut order: Vec<usize> = (0..poses.len()).collect();
            order.sort_by(|&a, &b| angle(b).total_cmp(&angle(a)));
            let moves = angle(order[0]) - angle(order[order.len() - 1]) > STILL;
            let mut own = order[..count].to_vec();
            own.sort_unstable();
            (moves && count >= RUN_LEN).then(|| self.distinct.block(own))
        };
        let blocks = joints.iter().filter_map(end);
        blocks.filter(|block| 2 * block.out_len() <= poses.len()).collect()
    }

    /// Lists two blocks for a forecast on more frames of the training clips: the middle halves of every second stretch.
    ///
    /// A stretch has at most a fifth of the poses and ends at a hole of missing frames. A block next to a hole would
    /// merge with the hole.
    pub fn spread(&self) -> Vec<Block> {
        let times = &self.distinct.times;
        let n = times.len();
        let is_hole = |at: usize| {
            let (last, next) = (times[at - 1], times[at]);
            last.clip != next.clip || next.frame > last.frame + 1
        };
        let (least, most) = (n.div_ceil(2 * STRETCHES), n.div_ceil(STRETCHES));
        let mut cuts = vec![0];
        for at in 1..n {
            let len = at - cuts[cuts.len() - 1];
            if len == most || len >= least && is_hole(at) {
                cuts.push(at);
            }
        }
        cuts.push(n);
        let middle = |ends: &[usize]| {
            let count = ((ends[1] - ends[0]) / 2).max(1);
            let start = ends[0] + (ends[1] - ends[0] - count) / 2;
            start..start + count
        };
        let middles: Vec<Range<usize>> = cuts.windows(2).map(middle).collect();
        let of_block = |first: usize| middles.iter().skip(first).step_by(2).cloned().flatten();
        let blocks = (0..2).map(|first| self.distinct.block(of_block(first).collect()));
        let is_some = |block: &Block| !block.own.is_empty() && block.out_len() + MIN_POSES <= n;
        blocks.filter(is_some).collect()
    }

    /// Lists the blocks that differ most from the remaining poses: the clips, or the runs if there is one clip.
    pub fn clips_or_runs(&self) -> Vec<Block> {
        let clips = self.clips();
        if clips.is_empty() { self.runs().to_vec() } else { clips }
    }

    /// Lists the clips that leave enough other poses; none if there is one clip.
    pub fn clips(&self) -> Vec<Block> {
        let times = &self.distinct.times;
        let cuts = (1..times.len()).filter(|&i| times[i].clip != times[i - 1].clip);
        let cuts: Vec<usize> = std::iter::once(0).chain(cuts).chain([times.len()]).collect();
        let clips = cuts.windows(2).map(|pair| pair[0]..pair[1]);
        let clips = clips.filter(|clip| clip.len() >= RUN_LEN && clip.len() < times.len());
        let blocks = clips.map(|clip| self.distinct.block(clip.collect()));
        blocks.filter(|block| block.out_len() + MIN_POSES <= times.len()).collect()
    }
}

/// Cuts distinct poses into ranges with nearly equal numbers of poses, repeats included. A range ends at the end of a
/// clip if a clip ends nearby.
fn ranges(distinct: &Distinct) -> Vec<Range<usize>> {
    if distinct.count() < 2 {
        return (0..distinct.count()).map(|at| at..at + 1).collect();
    }
    let (n, count) = (distinct.count(), (distinct.count() / RUN_LEN).clamp(2, RUNS));
    let half = n / count / 2;
    let near = |cut: usize| {
        let ends = cut.saturating_sub(half).max(1)..(cut + half).min(n);
        let ends = ends.filter(|&at| distinct.is_cut(at));
        ends.min_by_key(|at| at.abs_diff(cut)).unwrap_or(cut)
    };
    let starts = distinct.starts();
    let place = |pose: usize| starts.partition_point(|&start| start < pose).clamp(1, n - 1);
    let cut = |run: usize| near(place(run * starts[n] / count));
    let mut cuts: Vec<usize> = (1..count).map(cut).collect();
    cuts.insert(0, 0);
    cuts.push(n);
    cuts.dedup();
    cuts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::distinct::tests::{looped, moving};
    use super::*;
    use crate::envelope::correction::features::near;
    use crate::examples::Examples;
    use crate::examples::demo::{DemoOptions, demo};

    #[test]
    fn runs_are_contiguous_and_cover_all_poses() {
        for n in 2..60 {
            let folds = Folds::new(&moving(&[n])).runs().to_vec();
            assert_eq!(folds.len(), (n / 2).clamp(2, 10));
            let own: Vec<usize> = folds.iter().flat_map(|fold| fold.own.clone()).collect();
            assert_eq!(own, Vec::from_iter(0..n));
            let lengths = folds.iter().map(|fold| fold.own.len());
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
        }
    }

    #[test]
    fn runs_end_at_clip_ends() {
        let folds = Folds::new(&moving(&[33, 41, 26])).runs().to_vec();
        let ends: Vec<usize> = folds.iter().map(|fold| fold.own[fold.own.len() - 1] + 1).collect();
        assert_eq!(ends, [10, 20, 33, 40, 50, 60, 74, 80, 90, 100]);
    }

    #[test]
    fn a_held_pose_counts_once_per_frame() {
        let held: Vec<usize> = (0..20).chain([20; 20]).chain(20..40).collect();
        let folds = Folds::new(&moving(&[40]).only(&held)).runs().to_vec();
        let lengths: Vec<usize> = folds.iter().map(|fold| fold.own.len()).collect();
        assert_eq!(lengths, [6, 6, 6, 23, 1, 6, 6, 6]);
    }

    #[test]
    fn runs_of_a_loop_contain_every_pass() {
        let folds = Folds::new(&looped(40, 2)).runs().to_vec();
        assert_eq!(folds.len(), 10);
        assert_eq!(folds[1].own, [4, 5, 6, 7, 44, 45, 46, 47]);
        let mut own: Vec<usize> = folds.iter().flat_map(|fold| fold.own.clone()).collect();
        own.sort_unstable();
        assert_eq!(own, Vec::from_iter(0..80));
    }

    #[test]
    fn further_runs_cross_borders_and_parts_do_not() {
        let poses = moving(&[40]);
        let folds = Folds::new(&poses);
        let (blocks, parts) = (folds.overlapping(), folds.parts());
        assert_eq!(&blocks[..10], folds.runs());
        assert_eq!(blocks.len(), 19);
        assert_eq!(blocks[10].own, [2, 3, 4, 5]);
        assert_eq!(blocks[10].near, [0, 1, 6, 7]);
        let own: Vec<usize> = parts.iter().flat_map(|part| part.own.clone()).collect();
        assert_eq!(own, Vec::from_iter(0..40));
        assert_eq!(parts[3], Block { own: vec![6, 7], near: vec![5, 8] });
    }

    #[test]
    fn forecast_blocks_are_spread_over_the_poses() {
        let own = |poses: &Poses| -> Vec<Vec<usize>> {
            Folds::new(poses).spread().into_iter().map(|block| block.own).collect()
        };
        let runs = |starts: &[usize]| -> Vec<usize> {
            starts.iter().flat_map(|&start| start..start + 6).collect()
        };
        let long = moving(&[80]);
        assert_eq!(own(&long.only(&Vec::from_iter(0..60))), [runs(&[3, 27, 51]), runs(&[15, 39])]);
        // Five stretches between holes.
        let some: Vec<usize> = (0..80).filter(|frame| frame % 16 < 12).collect();
        assert_eq!(own(&long.only(&some)), [runs(&[3, 27, 51]), runs(&[15, 39])]);
        assert_eq!(own(&moving(&[8])), [vec![0, 4], vec![2, 6]]);
        assert!(own(&moving(&[6])).is_empty(), "too few would be left");
        let repeated = &Folds::new(&looped(30, 2)).spread()[1];
        assert_eq!((&repeated.own, &repeated.near), (&runs(&[15, 39]), &runs(&[9, 45])));
    }

    #[test]
    fn a_clip_that_leaves_too_few_poses_is_not_left_out() {
        let clips = |lengths: &[usize]| -> Vec<usize> {
            Folds::new(&moving(lengths)).clips().iter().map(|block| block.own.len()).collect()
        };
        assert_eq!(clips(&[20, 30]), [20, 30]);
        assert_eq!(clips(&[20, 5]), [5]);
        assert!(clips(&[30]).is_empty());
    }

    #[test]
    fn the_ends_of_ranges_are_left_out() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 40, held_out: 0, seed: 3 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let parents = examples.skeleton.parents.clone();
        let moving = |poses: &Poses| {
            let ranges = poses.angle_ranges();
            (0..ranges.len()).rev().max_by(|&a, &b| ranges[a].total_cmp(&ranges[b])).unwrap()
        };
        let poses = Poses::new(&examples, &frames);
        let joint = moving(&poses);
        let joints = near(&parents, joint, 1);
        let blocks = |poses: &Poses| Folds::new(poses).range_ends(poses, &joints, 0.25);
        for block in blocks(&poses) {
            let angle = |pose: usize, joint: usize| poses.angle(pose, joint).norm();
            let is_end = |joint: &usize| {
                let least =
                    block.own.iter().map(|&i| angle(i, *joint)).fold(f64::INFINITY, f64::min);
                let others = frames.iter().filter(|i| !block.own.contains(i));
                others.map(|&i| angle(i, *joint)).fold(0.0, f64::max) <= least
            };
            assert_eq!(block.own.len(), 10);
            assert!(joints.iter().any(is_end));
        }
        assert!(!blocks(&poses).is_empty());
    }

    #[test]
    fn a_clip_is_left_out_with_its_repeats() {
        let mut examples = demo(&DemoOptions { vertices: 200, poses: 40, held_out: 0, seed: 3 });
        examples.clip_starts = vec![0, 10, 20];
        let first_two = |examples: &Examples| {
            let poses = Poses::new(examples, &Vec::from_iter(0..40));
            Folds::new(&poses).clips()[..2].to_vec()
        };
        assert_eq!(first_two(&examples), [Block::row(0..10), Block::row(10..20)]);
        let joints = examples.joint_len();
        examples.transforms.copy_within(..5 * joints, 10 * joints);
        let [first, second] = &first_two(&examples)[..] else { panic!("two clips") };
        assert_eq!(first.near, [10, 11, 12, 13, 14]);
        assert_eq!(second.near, [0, 1, 2, 3, 4]);
    }
}
