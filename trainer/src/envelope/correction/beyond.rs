//! Blocks of poses beyond the others: what a map has to extrapolate to (METHOD §1.9).

use super::features::near;
use crate::constants::BEYOND;
use crate::envelope::skin::distinct::Distinct;
use crate::envelope::skin::poses::Poses;
use crate::kernel::outputs::Block;

/// Angles that spread less than this, in radians, are no range.
const STILL: f64 = 0.03;
/// Fewest poses of a block.
const FEWEST: usize = 2;

/// Lists blocks that a fit for one joint is to be tried on: whole clips, and of each joint near it the poses that turn
/// it most.
pub(super) fn beyond(
    distinct: &Distinct<'_>,
    parents: &[Option<usize>],
    joint: usize,
) -> Vec<Block> {
    let poses = distinct.poses;
    let own = clips(poses).into_iter().chain(ranges(poses, &near(parents, joint, 1)));
    let blocks = own.map(|own| distinct.block(own));
    blocks.filter(|block| 2 * block.out_len() <= poses.len()).collect()
}

/// Every clip, where there are several.
fn clips(poses: &Poses) -> Vec<Vec<usize>> {
    let times = poses.times();
    let cuts = (1..times.len()).filter(|&i| times[i].clip != times[i - 1].clip);
    let cuts: Vec<usize> = std::iter::once(0).chain(cuts).chain([times.len()]).collect();
    let clips = cuts.windows(2).map(|pair| pair[0]..pair[1]);
    clips.filter(|clip| clip.len() >= FEWEST).map(Vec::from_iter).collect()
}

/// Of each joint the quarter of the poses that turn it most.
fn ranges(poses: &Poses, joints: &[usize]) -> Vec<Vec<usize>> {
    let count = (BEYOND.get() * poses.len() as f64) as usize;
    if count < FEWEST {
        return Vec::new();
    }
    let range = |&joint: &usize| {
        let angle = |pose: usize| poses.angle(pose, joint).norm();
        let mut order: Vec<usize> = (0..poses.len()).collect();
        order.sort_by(|&a, &b| angle(b).total_cmp(&angle(a)));
        let moves = angle(order[0]) - angle(order[order.len() - 1]) > STILL;
        let mut own = order[..count].to_vec();
        own.sort_unstable();
        moves.then_some(own)
    };
    joints.iter().filter_map(range).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::examples::Examples;

    #[test]
    fn whole_clips_and_the_ends_of_ranges_are_left_out() {
        let mut examples = demo(&DemoOptions { vertices: 200, poses: 40, held_out: 0, seed: 3 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let parents = examples.skeleton.parents.clone();
        let moving = |poses: &Poses| {
            let ranges = poses.angle_ranges();
            (0..ranges.len()).rev().max_by(|&a, &b| ranges[a].total_cmp(&ranges[b])).unwrap()
        };
        let poses = Poses::new(&examples, &frames);
        let joint = moving(&poses);
        let distinct = Distinct::new(&poses);
        for block in beyond(&distinct, &parents, joint) {
            let angle = |pose: usize, joint: usize| poses.angle(pose, joint).norm();
            let is_end = |joint: &usize| {
                let least =
                    block.own.iter().map(|&i| angle(i, *joint)).fold(f64::INFINITY, f64::min);
                let others = frames.iter().filter(|i| !block.own.contains(i));
                others.map(|&i| angle(i, *joint)).fold(0.0, f64::max) <= least
            };
            assert_eq!(block.own.len(), 10);
            assert!(near(&parents, joint, 1).iter().any(is_end));
        }
        let ranges = beyond(&distinct, &parents, joint).len();
        assert!(ranges > 0);
        examples.clip_starts = vec![0, 15, 39];
        let poses = Poses::new(&examples, &frames);
        let found = beyond(&Distinct::new(&poses), &parents, joint);
        assert_eq!(found[0], Block::row(0..15));
        assert_eq!(found.len(), ranges + 1, "a clip that is more than half, or one pose, is none");
    }

    #[test]
    fn a_clip_is_left_out_with_what_repeats_it() {
        let mut examples = demo(&DemoOptions { vertices: 200, poses: 40, held_out: 0, seed: 3 });
        examples.clip_starts = vec![0, 10, 20];
        let first_two = |examples: &Examples| {
            let poses = Poses::new(examples, &Vec::from_iter(0..40));
            beyond(&Distinct::new(&poses), &examples.skeleton.parents, 1)[..2].to_vec()
        };
        assert_eq!(first_two(&examples), [Block::row(0..10), Block::row(10..20)]);
        let joints = examples.joint_len();
        examples.transforms.copy_within(..5 * joints, 10 * joints);
        let [first, second] = &first_two(&examples)[..] else { panic!("two clips") };
        assert_eq!(first.near, [10, 11, 12, 13, 14]);
        assert_eq!(second.near, [0, 1, 2, 3, 4]);
    }
}
