//! Folds of a cross-validation: runs of poses, for neighbours in an animation are almost the same pose, and single
//! frames left out would prove nothing (METHOD §1.9).

use super::distinct::Distinct;
use super::poses::Poses;
use crate::kernel::outputs::Block;
use std::ops::Range;

/// Folds of the training poses, fewer where they would be short.
const FOLDS: usize = 10;
/// Poses of a fold, so that it holds more than neighbours of what is left.
pub const FOLD_LEN: usize = 2;

/// Splits poses into folds.
pub fn folds(poses: &Poses) -> Vec<Block> {
    let distinct = Distinct::new(poses);
    ranges(&distinct).into_iter().map(|range| distinct.run(range)).collect()
}

/// Splits distinct poses into runs of nearly as many poses, repeats among them, two runs at least, that end where clips do if
/// one ends nearby.
pub fn ranges(distinct: &Distinct<'_>) -> Vec<Range<usize>> {
    let (n, count) = (distinct.count(), (distinct.count() / FOLD_LEN).clamp(2, FOLDS));
    let half = n / count / 2;
    let near = |cut: usize| {
        let ends = cut.saturating_sub(half).max(1)..(cut + half).min(n);
        let ends = ends.filter(|&at| distinct.is_cut(at));
        ends.min_by_key(|at| at.abs_diff(cut)).unwrap_or(cut)
    };
    let starts = distinct.starts();
    let place = |pose: usize| starts.partition_point(|&start| start < pose).clamp(1, n - 1);
    let cut = |fold: usize| near(place(fold * starts[n] / count));
    let mut cuts: Vec<usize> = (1..count).map(cut).collect();
    cuts.insert(0, 0);
    cuts.push(n);
    cuts.dedup();
    cuts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{looped, moving};
    use super::*;

    #[test]
    fn folds_are_contiguous_cover_all_and_differ_by_one_at_most() {
        for n in 2..60 {
            let folds = folds(&moving(&[n]));
            assert_eq!(folds.len(), (n / 2).clamp(2, 10));
            let own: Vec<usize> = folds.iter().flat_map(|fold| fold.own.clone()).collect();
            assert_eq!(own, Vec::from_iter(0..n));
            let lengths = folds.iter().map(|fold| fold.own.len());
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
        }
    }

    #[test]
    fn folds_end_where_clips_do() {
        let folds = folds(&moving(&[33, 41, 26]));
        let ends: Vec<usize> = folds.iter().map(|fold| fold.own[fold.own.len() - 1] + 1).collect();
        assert_eq!(ends, [10, 20, 33, 40, 50, 60, 74, 80, 90, 100]);
    }

    #[test]
    fn a_pose_that_is_held_counts_as_often_as_it_is_there() {
        let held: Vec<usize> = (0..20).chain([20; 20]).chain(20..40).collect();
        let folds = folds(&moving(&[40]).only(&held));
        let lengths: Vec<usize> = folds.iter().map(|fold| fold.own.len()).collect();
        assert_eq!(lengths, [6, 6, 6, 23, 1, 6, 6, 6]);
    }

    #[test]
    fn folds_of_a_loop_hold_every_pass() {
        let folds = folds(&looped(40, 2));
        assert_eq!(folds.len(), 10);
        assert_eq!(folds[1].own, [4, 5, 6, 7, 44, 45, 46, 47]);
        let mut own: Vec<usize> = folds.iter().flat_map(|fold| fold.own.clone()).collect();
        own.sort_unstable();
        assert_eq!(own, Vec::from_iter(0..80));
    }
}
