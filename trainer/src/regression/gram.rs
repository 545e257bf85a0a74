//! Kernel ridge regression of outputs that are known only by their inner products, with every sample a centre (METHOD
//! §2.2).
//!
//! The regression measures how well samples with very many outputs predict each other.

use super::inputs::{Inputs, WIDTHS};
use super::outputs::{Block, LeftOut};
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use sinew_runtime::envelope::GroupKernel;

/// Candidate ridges, as shares of the kernel's mean diagonal: a ridge chosen on some samples then holds for all.
const RIDGES: [f64; 5] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Regression of n samples on each other, with the residuals of the samples.
pub struct GramRegression {
    /// Kernel matrix of the samples, zero at rest, n x n.
    kernel: Mat<f64>,
    /// Inner products of the samples' outputs, n x n.
    gram: Mat<f64>,
    ridge: f64,
}

/// Squared error of each sample, predicted by other samples and summed over the outputs.
pub struct SampleErrors {
    /// Errors if only the sample is left out.
    pub alone: Vec<f64>,
    /// Errors if the sample's block is left out.
    pub block: Vec<f64>,
}

impl GramRegression {
    /// Chooses width and ridge by leaving out blocks of some samples; `None` if no fit can be made.
    ///
    /// - `some`: samples that the choice uses.
    /// - `blocks`: blocks that cover `some`; their indices count the elements of `some`.
    pub fn choose(
        inputs: &Inputs,
        gram: Mat<f64>,
        some: &[usize],
        blocks: &[Block],
    ) -> Option<Self> {
        let pick =
            |m: &Mat<f64>| Mat::from_fn(some.len(), some.len(), |i, j| m[(some[i], some[j])]);
        let picked_gram = pick(&gram);
        let (mut best, mut least) = (None, f64::INFINITY);
        // With the narrowest width, only a frame's neighbours would predict the frame.
        for &width in &WIDTHS[1..] {
            let kernel = pick(&inputs.kernel_matrix(GroupKernel::Gaussian, width));
            let mean = kernel.diagonal().column_vector().sum() / some.len() as f64;
            for ridge in RIDGES.map(|ridge| ridge * mean) {
                let Some(left) = SampleErrors::new(&kernel, &picked_gram, ridge, blocks) else {
                    continue;
                };
                let sum = left.block.iter().sum();
                if sum < least {
                    (best, least) = (Some((width, ridge)), sum);
                }
            }
        }
        let (width, ridge) = best?;
        Some(Self { kernel: inputs.kernel_matrix(GroupKernel::Gaussian, width), gram, ridge })
    }

    /// Returns n.
    pub fn sample_len(&self) -> usize {
        self.gram.nrows()
    }

    /// Returns the squared residual of a sample, summed over the outputs.
    pub fn left(&self, sample: usize) -> f64 {
        self.gram[(sample, sample)]
    }

    /// Predicts every sample by the others; `None` if rounding makes a fit indefinite.
    ///
    /// - `blocks`: blocks that cover all samples.
    pub fn errors(&self, blocks: &[Block]) -> Option<SampleErrors> {
        SampleErrors::new(&self.kernel, &self.gram, self.ridge, blocks)
    }

    /// Predicts every sample by the other samples of `by`. Returns the squared error over its variance, and the squared
    /// error, both summed over the outputs. `None` if rounding makes the fit indefinite.
    ///
    /// - `by`: samples that predict, ascending.
    ///
    /// Let A = K + λI of the samples in `by`. A sample in `by` has the error `[A⁻¹ y]_i / [A⁻¹]_ii` and the variance `1
    /// / [A⁻¹]_ii`. Any other sample has the error y - kᵀA⁻¹y and the variance K_ii + λ - kᵀA⁻¹k.
    pub fn standardised_errors(&self, by: &[usize]) -> Option<Vec<(f64, f64)>> {
        let (n, m) = (self.sample_len(), by.len());
        let others: Vec<usize> = (0..n).filter(|j| by.binary_search(j).is_err()).collect();
        let of = |matrix: &Mat<f64>, columns: &[usize]| {
            Mat::from_fn(m, columns.len(), |i, j| matrix[(by[i], columns[j])])
        };
        let mut ridged = of(&self.kernel, by);
        (0..m).for_each(|i| ridged[(i, i)] += self.ridge);
        let inverse = ridged.llt(Side::Lower).ok()?.inverse();
        let half = of(&self.gram, by) * &inverse;
        let (kernel, gram) = (of(&self.kernel, &others), of(&self.gram, &others));
        let (weights, seen) = (&inverse * &kernel, &half * &kernel);
        let product = |a: &Mat<f64>, b: &Mat<f64>, column: usize| -> f64 {
            a.col_as_slice(column).iter().zip(b.col_as_slice(column)).map(|(a, b)| a * b).sum()
        };
        let of_sample = |j: usize| {
            if let Ok(i) = by.binary_search(&j) {
                let precision = inverse[(i, i)];
                let squared = product(&inverse, &half, i);
                return (squared / precision, squared / precision.powi(2));
            }
            let other = others.partition_point(|&other| other < j);
            let [crossed, own] = [&gram, &seen].map(|of| product(&weights, of, other));
            let squared = (self.gram[(j, j)] - 2.0 * crossed + own).max(0.0);
            let explained = product(&weights, &kernel, other);
            let variance = self.kernel[(j, j)] + self.ridge - explained;
            (squared / variance.max(self.ridge), squared)
        };
        Some((0..n).map(of_sample).collect())
    }

    /// Conditions the regression on a sample: kernel and residuals lose the part that the sample predicts.
    pub fn learn(&mut self, sample: usize) {
        let n = self.sample_len();
        let scale = 1.0 / (self.kernel[(sample, sample)].max(0.0) + self.ridge);
        let row = |m: &Mat<f64>| (0..n).map(|i| m[(sample, i)]).collect::<Vec<f64>>();
        let (kernel, gram) = (row(&self.kernel), row(&self.gram));
        let share: Vec<f64> = kernel.iter().map(|k| k * scale).collect();
        for j in 0..n {
            let column = self.kernel.col_as_slice_mut(j);
            column.iter_mut().zip(&share).for_each(|(k, s)| *k -= s * kernel[j]);
            let column = self.gram.col_as_slice_mut(j);
            let by = share[j] * gram[sample] - gram[j];
            column.iter_mut().zip(&share).zip(&gram).for_each(|((g, s), own)| {
                *g += s * by - share[j] * own;
            });
        }
    }
}

impl SampleErrors {
    /// Computes the errors. With A = K + λI, a fit to all samples has the residuals λA⁻¹y; λ cancels. A single sample
    /// is a block of one.
    fn new(kernel: &Mat<f64>, gram: &Mat<f64>, ridge: f64, blocks: &[Block]) -> Option<Self> {
        let n = kernel.nrows();
        let mut ridged = kernel.clone();
        (0..n).for_each(|i| ridged[(i, i)] += ridge);
        let inverse = ridged.llt(Side::Lower).ok()?.inverse();
        let half = gram * &inverse;
        let columns =
            |m: &Mat<f64>, out: &[usize]| Mat::from_fn(n, out.len(), |r, i| m[(r, out[i])]);
        let predict = |block: &Block, errors: &mut [f64]| {
            let out: Vec<usize> = block.out().collect();
            let remainder = Mat::from_fn(out.len(), out.len(), |i, j| inverse[(out[i], out[j])]);
            let residuals = columns(&inverse, &out).transpose() * columns(&half, &out);
            let products = LeftOut::new(&remainder)?.products(&residuals);
            block.own.iter().enumerate().for_each(|(i, &sample)| errors[sample] = products[(i, i)]);
            Some(())
        };
        let (mut alone, mut block) = (vec![0.0; n], vec![0.0; n]);
        for sample in 0..n {
            predict(&Block::row(sample..sample + 1), &mut alone)?;
        }
        for left_out in blocks {
            predict(left_out, &mut block)?;
        }
        Some(Self { alone, block })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 12;
    const RIDGE: f64 = 1e-2;

    /// Returns a regression of samples on a spiral, with outputs n x 2.
    fn regression() -> (GramRegression, Mat<f64>) {
        let inputs = Mat::from_fn(2, N, |r, i| {
            let t = 0.4 * i as f64;
            t * [t.cos(), t.sin()][r]
        });
        let outputs = Mat::from_fn(N, 2, |i, o| [inputs[(0, i)].sin(), inputs[(1, i)] * 0.3][o]);
        let kernel = Inputs::new(inputs).unwrap().kernel_matrix(GroupKernel::Gaussian, 4.0);
        let gram = &outputs * outputs.transpose();
        (GramRegression { gram, kernel, ridge: RIDGE }, outputs)
    }

    /// Returns the squared error of a sample that some others predict, by solving for them.
    fn squared_error(kernel: &Mat<f64>, outputs: &Mat<f64>, sample: usize, by: &[usize]) -> f64 {
        let among = Mat::from_fn(by.len(), by.len(), |i, j| {
            kernel[(by[i], by[j])] + if i == j { RIDGE } else { 0.0 }
        });
        let truth = Mat::from_fn(by.len(), 2, |i, o| outputs[(by[i], o)]);
        let solution = among.partial_piv_lu().inverse() * truth;
        let predicted = |o: usize| -> f64 {
            (0..by.len()).map(|k| kernel[(sample, by[k])] * solution[(k, o)]).sum()
        };
        (0..2).map(|o| (outputs[(sample, o)] - predicted(o)).powi(2)).sum()
    }

    #[test]
    fn samples_left_out_in_closed_form_equal_fits_without_them() {
        let (regression, outputs) = regression();
        let scattered = Block { own: vec![7, 9, 11], near: vec![8, 2] };
        let blocks = [
            Block::row(0..5),
            Block::row(5..7),
            Block { own: vec![8, 10], near: vec![9] },
            scattered,
        ];
        let found = regression.errors(&blocks).unwrap();
        for block in blocks {
            for &sample in &block.own {
                let others: Vec<usize> = (0..N).filter(|&i| i != sample).collect();
                let outside: Vec<usize> =
                    (0..N).filter(|i| !block.out().any(|out| out == *i)).collect();
                let alone = squared_error(&regression.kernel, &outputs, sample, &others);
                let blocked = squared_error(&regression.kernel, &outputs, sample, &outside);
                assert!((found.alone[sample] - alone).abs() < 1e-9 * (1.0 + alone));
                assert!((found.block[sample] - blocked).abs() < 1e-9 * (1.0 + blocked));
            }
        }
    }

    #[test]
    fn standardised_errors_are_squared_errors_over_their_variance() {
        let (regression, outputs) = regression();
        let kept: Vec<usize> = (0..N).filter(|&i| i != 4).collect();
        let found = regression.standardised_errors(&kept).unwrap();
        for (sample, found) in found.into_iter().enumerate() {
            let others: Vec<usize> = kept.iter().copied().filter(|&i| i != sample).collect();
            let squared = squared_error(&regression.kernel, &outputs, sample, &others);
            let among = Mat::from_fn(others.len(), others.len(), |i, j| {
                let ridge = if i == j { RIDGE } else { 0.0 };
                regression.kernel[(others[i], others[j])] + ridge
            });
            let near = Mat::from_fn(others.len(), 1, |i, _| regression.kernel[(others[i], sample)]);
            let explained = (near.transpose() * among.partial_piv_lu().inverse() * &near)[(0, 0)];
            let variance = regression.kernel[(sample, sample)] + RIDGE - explained;
            assert!((found.1 - squared).abs() < 1e-8 * (1.0 + squared));
            let standardised = squared / variance;
            assert!((found.0 - standardised).abs() < 1e-8 * (1.0 + standardised));
        }
    }

    #[test]
    fn learning_samples_one_by_one_equals_a_fit_to_all_of_them() {
        let (mut regression, outputs) = regression();
        let kernel = regression.kernel.clone();
        let learnt = [7, 2, 10];
        learnt.into_iter().for_each(|sample| regression.learn(sample));
        for sample in (0..N).filter(|sample| !learnt.contains(sample)) {
            let expected = squared_error(&kernel, &outputs, sample, &learnt);
            assert!((regression.left(sample) - expected).abs() < 1e-9 * (1.0 + expected));
        }
    }
}
