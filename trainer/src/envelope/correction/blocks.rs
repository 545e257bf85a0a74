//! Blocks of poses that are left out: by some maps are chosen, by others it is told how well they do.

use crate::envelope::skin::distinct::Distinct;
use crate::envelope::skin::folds::{FOLD_LEN, ranges};
use crate::envelope::skin::poses::Poses;
use crate::kernel::outputs::Block;
use std::ops::Range;

/// Parts of a fold, fewer where they would be short.
const PARTS: usize = 4;

/// Blocks of the training poses.
pub struct Blocks<'a> {
    /// The poses, those that are one together.
    pub distinct: Distinct<'a>,
    /// The folds, and one more across the middle of each pair: more blocks choose better.
    pub blocks: Vec<Block>,
    /// The folds in parts: the model has seen all poses, and of fits that have not seen a tenth of
    /// them the error is larger than its own.
    pub parts: Vec<Block>,
}

impl<'a> Blocks<'a> {
    /// Cuts poses into blocks.
    pub fn new(poses: &'a Poses) -> Self {
        let distinct = Distinct::new(poses);
        let folds = ranges(&distinct);
        let middle = |fold: &Range<usize>| (fold.start + fold.end) / 2;
        let parts = |fold: &Range<usize>| {
            let (start, len) = (fold.start, fold.len());
            let count = (len / FOLD_LEN).clamp(1, PARTS);
            let cut = move |part: usize| start + part * len / count;
            let run = |part: usize| distinct.run(cut(part)..cut(part + 1));
            (0..count).map(run).collect::<Vec<_>>()
        };
        let parts = folds.iter().flat_map(parts).collect();
        let pairs = folds.windows(2);
        let across: Vec<_> = pairs.map(|pair| middle(&pair[0])..middle(&pair[1])).collect();
        let blocks = folds.into_iter().chain(across).map(|range| distinct.run(range)).collect();
        Self { distinct, blocks, parts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::skin::folds::folds;
    use crate::envelope::skin::testing::moving;

    #[test]
    fn blocks_lie_across_two_folds_and_parts_in_one() {
        let poses = moving(&[40]);
        let folds = folds(&poses);
        let Blocks { blocks, parts, .. } = Blocks::new(&poses);
        assert_eq!(blocks[..10], folds);
        assert_eq!(blocks.len(), 19);
        assert_eq!(blocks[10].own, [2, 3, 4, 5]);
        assert_eq!(blocks[10].near, [0, 1, 6, 7]);
        let own: Vec<usize> = parts.iter().flat_map(|part| part.own.clone()).collect();
        assert_eq!(own, Vec::from_iter(0..40));
        assert_eq!(parts[3], Block { own: vec![6, 7], near: vec![5, 8] });
    }
}
