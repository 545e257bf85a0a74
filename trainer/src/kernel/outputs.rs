//! What samples are to give, in blocks, and the mean by which errors of blocks make a score.

use crate::constants::GENTLE;
use crate::numeric::columns::some;
use faer::Mat;
use std::ops::Range;

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
    /// Parts of the first blocks, and of which: what is told of a fit's error leaves out one of them at a time.
    pub parts: Vec<(Block, usize)>,
    /// How many blocks, the last, are of samples beyond the others.
    pub beyond: usize,
    /// The outputs as a fit without each block is to see them, where they depend on that.
    pub without: Vec<Mat<f64>>,
    /// The squared size, summed over the samples, of what would be left without any fit.
    pub signal: f64,
    /// The squared size in a sample that counts as nothing.
    pub negligible: f64,
    /// The same of one output where fits are compared: of errors that are smaller none is better than another.
    pub exact: f64,
    /// Most values of a map's certainty.
    pub certainty: usize,
}

impl Outputs {
    /// The first outputs, without the last that hold no more than a share of the squared size.
    #[must_use]
    pub fn leading(&self, share: f64) -> Self {
        let sizes: Vec<f64> = self.all.col_iter().map(|c| c.squared_norm_l2()).collect();
        let mut spare = share * sizes.iter().sum::<f64>();
        let last = sizes.iter().rev().take_while(|&&size| {
            spare -= size;
            spare >= 0.0
        });
        let len = sizes.len() - last.count();
        self.columns(&Vec::from_iter(0..len))
    }

    /// Some of the outputs.
    #[must_use]
    pub fn columns(&self, columns: &[usize]) -> Self {
        let own = |m: &Mat<f64>| some(m, columns);
        Self {
            all: own(&self.all),
            blocks: self.blocks.clone(),
            parts: self.parts.clone(),
            without: self.without.iter().map(own).collect(),
            ..*self
        }
    }

    /// Several outputs of the same samples side by side.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn beside(several: &[Self]) -> Self {
        let beside = |of: &dyn Fn(&Self) -> &Mat<f64>| {
            let columns = several.iter().flat_map(|own| of(own).col_iter());
            let columns: Vec<_> = columns.collect();
            Mat::from_fn(of(&several[0]).nrows(), columns.len(), |i, k| columns[k][i])
        };
        let sum = |of: fn(&Self) -> f64| several.iter().map(of).sum::<f64>();
        let len = sum(|own| own.all.ncols() as f64).max(1.0);
        let first = &several[0];
        Self {
            all: beside(&|own| &own.all),
            blocks: first.blocks.clone(),
            parts: first.parts.clone(),
            without: (0..first.without.len()).map(|b| beside(&|own| &own.without[b])).collect(),
            signal: sum(|own| own.signal),
            exact: sum(|own| own.exact * own.all.ncols() as f64) / len,
            ..*first
        }
    }

    /// Returns the outputs of what a block leaves out, as a fit without it is to see them.
    pub fn of_block(&self, block: usize) -> Mat<f64> {
        self.of_part(&self.blocks[block], block)
    }

    /// Returns the same of a part of a block.
    pub fn of_part(&self, block: &Block, of: usize) -> Mat<f64> {
        block.rows(self.without.get(of).unwrap_or(&self.all))
    }

    /// How many times as much there is to predict of samples as their own blocks see them: 1 where outputs do not depend
    /// on that.
    pub fn unseen(&self) -> f64 {
        let pairs = || self.without.iter().zip(&self.blocks);
        let own: f64 = pairs().map(|(outputs, block)| size(outputs, block)).sum();
        let seen: f64 = pairs().map(|(_, block)| size(&self.all, block)).sum();
        if own > seen && seen > 0.0 { own / seen } else { 1.0 }
    }

    /// How many times a doubt is to count against adding what is predicted, as a power of two: 0 where nothing of the base
    /// was fitted. What has to be mended where samples tell nothing is taken to lie between what is known to be left, of
    /// samples as their own blocks see them, and what would be without any fit.
    pub fn caution(&self) -> u8 {
        let pairs = self.without.iter().zip(&self.blocks);
        let left: f64 = pairs.map(|(outputs, block)| size(outputs, block)).sum();
        if left > 0.0 {
            (0.5 * (self.signal / left).log2()).round().clamp(0.0, 15.0) as u8
        } else {
            0
        }
    }

    /// Scores of predicting nothing: each output's size, over the samples as their own blocks see
    /// them.
    pub fn sizes(&self) -> Vec<f64> {
        let blocks = 0..self.blocks.len();
        let size = |o: usize| {
            gentle_mean(blocks.clone().map(|b| {
                let own = self.blocks[b].own.len();
                let size = self.of_block(b).col(o).subrows(0, own).squared_norm_l2();
                size + self.exact * own as f64
            }))
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// The squared size of what a block's own samples are to give.
fn size(outputs: &Mat<f64>, block: &Block) -> f64 {
    block.own.iter().map(|&sample| outputs.row(sample).squared_norm_l2()).sum()
}

/// Returns the power mean of the squared errors of blocks.
pub fn gentle_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(GENTLE.get())));
    (sum / f64::from(count.max(1))).powf(1.0 / GENTLE.get())
}
