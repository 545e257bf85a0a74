//! Folds of a cross-validation: runs of poses, for neighbours in an animation are almost the same pose, and single
//! frames left out would prove nothing (METHOD §1.9).

use super::poses::Time;
use crate::kernel::outputs::Block;
use std::ops::Range;

/// Folds of the training poses, fewer where they would be short.
const FOLDS: usize = 10;
/// Poses of a fold, so that it holds more than neighbours of what is left.
pub const FOLD_LEN: usize = 2;
/// Frames on either side of a fold that a fit without it does not see either.
const GAP: usize = 3;

/// Poses that are left out at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fold {
    /// The poses that are predicted.
    pub own: Range<usize>,
    /// They and their neighbours: what the fit that predicts them does not see.
    pub out: Range<usize>,
}

impl Fold {
    /// The fold of some poses in a row.
    pub fn new(own: Range<usize>, times: &[Time]) -> Self {
        let gap = GAP.min(own.len() / 2);
        let near = |a: usize, b: usize| {
            times[a].clip == times[b].clip && times[a].frame.abs_diff(times[b].frame) <= gap
        };
        let before = (0..own.start).rev().take_while(|&i| near(i, own.start)).count();
        let after = (own.end..times.len()).take_while(|&i| near(i, own.end - 1)).count();
        Self { out: own.start - before..own.end + after, own }
    }
}

impl From<Fold> for Block {
    fn from(Fold { own, out }: Fold) -> Self {
        Self { near: out.filter(|i| !own.contains(i)).collect(), own: own.collect() }
    }
}

/// Splits poses into runs of nearly equal length, two at least, that end where clips do if one ends nearby.
pub fn folds(times: &[Time]) -> Vec<Fold> {
    let (n, count) = (times.len(), (times.len() / FOLD_LEN).clamp(2, FOLDS));
    let is_end = |cut: usize| times[cut - 1].clip != times[cut].clip;
    let half = n / count / 2;
    let near = |cut: usize| {
        let ends = (cut.saturating_sub(half).max(1)..(cut + half).min(n)).filter(|&at| is_end(at));
        ends.min_by_key(|at| at.abs_diff(cut)).unwrap_or(cut)
    };
    let mut cuts: Vec<usize> = (1..count).map(|fold| near(fold * n / count)).collect();
    cuts.insert(0, 0);
    cuts.push(n);
    cuts.dedup();
    cuts.windows(2).map(|pair| Fold::new(pair[0]..pair[1], times)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poses of clips of so many frames.
    fn clips(lengths: &[usize]) -> Vec<Time> {
        let clips = lengths.iter().enumerate();
        clips
            .flat_map(|(clip, &len)| {
                (0..len).map(move |frame| Time { clip, frame: 1000 * clip + frame })
            })
            .collect()
    }

    #[test]
    fn folds_are_contiguous_cover_all_and_differ_by_one_at_most() {
        for n in 2..60 {
            let folds = folds(&clips(&[n]));
            assert_eq!(folds.len(), (n / 2).clamp(2, 10));
            let own: Vec<usize> = folds.iter().flat_map(|fold| fold.own.clone()).collect();
            assert_eq!(own, Vec::from_iter(0..n));
            let lengths = folds.iter().map(|fold| fold.own.len());
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
        }
    }

    #[test]
    fn folds_end_where_clips_do() {
        let folds = folds(&clips(&[33, 41, 26]));
        let ends: Vec<usize> = folds.iter().map(|fold| fold.own.end).collect();
        assert_eq!(ends, [10, 20, 33, 40, 50, 60, 74, 80, 90, 100]);
    }

    #[test]
    fn neighbours_of_a_fold_are_left_out_with_it() {
        let times = clips(&[20, 30]);
        assert_eq!(Fold::new(5..12, &times).out, 2..15);
        assert_eq!(Fold::new(2..4, &times).out, 1..5, "few poses have few neighbours");
        assert_eq!(Fold::new(20..30, &times).out, 20..33, "not across clips");
        let mut apart = times;
        apart[15..20].iter_mut().for_each(|time| time.frame += 9);
        assert_eq!(Fold::new(5..15, &apart).out, 2..15, "nor across frames that are missing");
        let block = Block::from(Fold { own: 3..5, out: 2..6 });
        assert_eq!(block, Block { own: vec![3, 4], near: vec![2, 5] });
    }
}
