//! What samples are to give, in blocks, and the mean by which errors of blocks make a score.

use faer::{Mat, MatRef};
use std::ops::Range;

/// Power of the mean over blocks. Near 0 it is the geometric mean, in which every block counts by
/// how much its error grows or shrinks: in a sum of squares the block that is hardest to foresee
/// would decide alone.
const GENTLE: f64 = 0.1;

/// What the samples are to give.
pub struct Outputs {
    /// n x r.
    pub all: Mat<f64>,
    /// Contiguous blocks of samples that cover all, the last ones perhaps again.
    pub blocks: Vec<Range<usize>>,
    /// The outputs as a fit without each block is to see them, where they depend on that.
    pub without: Vec<Mat<f64>>,
}

impl Outputs {
    /// Returns a block's outputs, as a fit without it is to see them.
    pub fn of_block(&self, block: usize) -> MatRef<'_, f64> {
        let Range { start, end } = self.blocks[block];
        self.without.get(block).unwrap_or(&self.all).subrows(start, end - start)
    }

    /// Scores of predicting nothing: each output's size, over the samples as their own blocks see
    /// them.
    pub fn sizes(&self) -> Vec<f64> {
        let blocks = 0..self.blocks.len();
        let size = |o: usize| {
            gentle_mean(blocks.clone().map(|b| self.of_block(b).col(o).squared_norm_l2()))
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// Returns the power mean of the squared errors of blocks.
pub fn gentle_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(GENTLE)));
    (sum / f64::from(count.max(1))).powf(1.0 / GENTLE)
}
