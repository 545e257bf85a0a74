//! What samples are to give, in blocks, and the mean by which errors of blocks make a score.

use crate::numeric::columns::some;
use faer::Mat;
use std::ops::Range;

/// Power of the mean over blocks. Near 0 the mean is geometric, so that the hardest block does not decide alone.
const GENTLE: f64 = 0.1;

/// Samples that are left out at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Those that are predicted.
    pub own: Vec<usize>,
    /// Others that the fit that predicts them does not see either.
    pub near: Vec<usize>,
}

impl Block {
    /// A block of samples in a row, with nothing near.
    pub fn row(own: Range<usize>) -> Self {
        Self { own: own.collect(), near: Vec::new() }
    }

    /// Counts what is left out.
    pub fn out_len(&self) -> usize {
        self.own.len() + self.near.len()
    }

    /// Lists what is left out: its own first.
    pub fn out(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.own.iter().chain(&self.near).copied()
    }

    /// Lists those of n samples that are not left out.
    pub fn others(&self, n: usize) -> Vec<usize> {
        let mut is_other = vec![true; n];
        self.out().for_each(|sample| is_other[sample] = false);
        (0..n).filter(|&sample| is_other[sample]).collect()
    }

    /// Takes the rows of what is left out.
    pub fn rows(&self, all: &Mat<f64>) -> Mat<f64> {
        let mut rows = Mat::zeros(self.out_len(), all.ncols());
        for (out, all) in rows.col_iter_mut().zip(all.col_iter()) {
            out.iter_mut().zip(self.out()).for_each(|(out, sample)| *out = all[sample]);
        }
        rows
    }
}

/// What the samples are to give.
pub struct Outputs {
    /// n x r.
    pub all: Mat<f64>,
    /// Blocks of samples, of which the first ones cover all.
    pub blocks: Vec<Block>,
    /// Parts of the first blocks, left out one at a time to estimate a fit's error.
    pub parts: Vec<Block>,
    /// How many blocks, the last, are of samples beyond the others.
    pub beyond: usize,
    /// The squared size, summed over the samples, of what would be left without any fit.
    pub signal: f64,
    /// The squared size in a sample that counts as nothing.
    pub negligible: f64,
    /// Most values of a map's certainty.
    pub certainty: usize,
}

impl Outputs {
    /// Returns some of the outputs.
    #[must_use]
    pub fn columns(&self, columns: &[usize]) -> Self {
        Self {
            all: some(&self.all, columns),
            blocks: self.blocks.clone(),
            parts: self.parts.clone(),
            ..*self
        }
    }

    /// Several outputs of the same samples side by side.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn beside(several: &[Self]) -> Self {
        let columns: Vec<_> = several.iter().flat_map(|own| own.all.col_iter()).collect();
        let first = &several[0];
        Self {
            all: Mat::from_fn(first.all.nrows(), columns.len(), |i, k| columns[k][i]),
            blocks: first.blocks.clone(),
            parts: first.parts.clone(),
            signal: several.iter().map(|own| own.signal).sum(),
            ..*first
        }
    }

    /// Scores of predicting nothing: each output's size in the blocks.
    pub fn sizes(&self) -> Vec<f64> {
        let size = |o: usize| {
            gentle_mean(self.blocks.iter().map(|block| {
                let own = block.own.iter().map(|&sample| self.all[(sample, o)].powi(2));
                own.sum::<f64>()
            }))
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// Returns the power mean of the squared errors of blocks.
pub fn gentle_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(GENTLE)));
    (sum / f64::from(count.max(1))).powf(1.0 / GENTLE)
}
