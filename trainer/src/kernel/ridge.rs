//! Kernel ridge regression with its width and ridge chosen by blocks left out (METHOD §1.9, §2.2).

use faer::linalg::solvers::{SelfAdjointEigen, Solve};
use faer::{Mat, Side};
use serde::Serialize;
use std::ops::Range;

/// Share of the linear kernel beside the gaussian, so that the linear part is penalised too: an
/// unpenalised tail of many inputs overfits.
const LINEAR: f64 = 0.2;
/// Inputs that spread less than this (RMS) over the samples carry nothing.
const STILL: f64 = 1e-5;
/// Candidate squared widths, in median squared distances of the samples.
const WIDTHS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
/// Candidate ridges, relative to the kernel matrix's largest eigenvalue.
const RIDGES: [f64; 9] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// A width and a ridge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Squared width over the median squared distance.
    pub width: f64,
    /// Ridge over the largest eigenvalue.
    pub ridge: f64,
    /// Squared error of the outputs, each sample predicted without its block.
    pub error: f64,
}

/// A fitted map from d inputs to o outputs; centres are the samples.
pub struct KernelMap {
    /// Inputs in use, of those that were given.
    used: Vec<usize>,
    /// Mean of the inputs in use.
    mean: Vec<f64>,
    /// Centred centres, one a column, used x n.
    centres: Mat<f64>,
    /// Coefficients, n x o.
    coefficients: Mat<f64>,
    /// Mean output, o.
    offset: Vec<f64>,
    kernel: Kernel,
    /// What was chosen.
    pub choice: Choice,
}

/// gaussian + [`LINEAR`] x·x'/m, m the median squared distance.
#[derive(Clone, Copy)]
struct Kernel {
    inverse_width: f64,
    linear: f64,
}

impl Kernel {
    fn value(&self, squared_distance: f64, product: f64) -> f64 {
        (-squared_distance * self.inverse_width).exp() + self.linear * product
    }
}

impl KernelMap {
    /// Fits samples (inputs d x n, outputs n x o), choosing width and ridge by leaving out blocks.
    ///
    /// Returns `None` where the samples are too few or too alike to tell a width.
    pub fn fit(inputs: &Mat<f64>, outputs: &Mat<f64>, blocks: &[Range<usize>]) -> Option<Self> {
        let n = inputs.ncols();
        let mean_of = |row: usize| (0..n).map(|i| inputs[(row, i)]).sum::<f64>() / n as f64;
        let spread = |row: usize, mean: f64| {
            let sum: f64 = (0..n).map(|i| (inputs[(row, i)] - mean).powi(2)).sum();
            (sum / n as f64).sqrt()
        };
        let (used, mean): (Vec<_>, Vec<_>) = (0..inputs.nrows())
            .map(|row| (row, mean_of(row)))
            .filter(|&(row, mean)| spread(row, mean) > STILL)
            .unzip();
        let centres = Mat::from_fn(used.len(), n, |r, i| inputs[(used[r], i)] - mean[r]);
        let offset: Vec<f64> = (0..outputs.ncols())
            .map(|o| outputs.col_as_slice(o).iter().sum::<f64>() / n as f64)
            .collect();
        let centred = Mat::from_fn(n, outputs.ncols(), |i, o| outputs[(i, o)] - offset[o]);

        let products = centres.transpose() * &centres;
        let squared = |i: usize, j: usize| {
            (products[(i, i)] + products[(j, j)] - 2.0 * products[(i, j)]).max(0.0)
        };
        let mut distances: Vec<f64> = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| squared(i, j))
            .filter(|&d| d > 0.0)
            .collect();
        if distances.is_empty() {
            return None;
        }
        let middle = distances.len() / 2;
        let median = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;

        let mut best: Option<(Choice, Kernel, Mat<f64>)> = None;
        for width in WIDTHS {
            let kernel = Kernel { inverse_width: 1.0 / (width * median), linear: LINEAR / median };
            let matrix = Mat::from_fn(n, n, |i, j| kernel.value(squared(i, j), products[(i, j)]));
            let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
            let largest = eigen.S().column_vector()[n - 1];
            for ridge in RIDGES {
                let root = inverse_root(&eigen, ridge * largest);
                let coefficients = &root * (root.transpose() * &centred);
                let error = left_out_error(&root, &coefficients, blocks)?;
                if best.as_ref().is_none_or(|(choice, ..)| error < choice.error) {
                    best = Some((Choice { width, ridge, error }, kernel, coefficients));
                }
            }
        }
        let (choice, kernel, coefficients) = best?;
        Some(Self { used, mean, centres, coefficients, offset, kernel, choice })
    }

    /// Evaluates the map at one input of d values.
    pub fn evaluate(&self, input: &[f64]) -> Vec<f64> {
        let x: Vec<f64> =
            self.used.iter().zip(&self.mean).map(|(&r, mean)| input[r] - mean).collect();
        let mut out = self.offset.clone();
        for i in 0..self.centres.ncols() {
            let centre = self.centres.col_as_slice(i);
            let (mut squared, mut product) = (0.0, 0.0);
            for (a, b) in x.iter().zip(centre) {
                squared += (a - b) * (a - b);
                product += a * b;
            }
            let value = self.kernel.value(squared, product);
            for (o, out) in out.iter_mut().enumerate() {
                *out += value * self.coefficients[(i, o)];
            }
        }
        out
    }
}

/// A matrix R with R Rᵀ = S⁻¹, S = K + λI.
fn inverse_root(eigen: &SelfAdjointEigen<f64>, ridge: f64) -> Mat<f64> {
    let (u, values) = (eigen.U(), eigen.S().column_vector());
    Mat::from_fn(u.nrows(), u.ncols(), |i, k| u[(i, k)] / (values[k].max(0.0) + ridge).sqrt())
}

/// Squared error of the samples, each block predicted by the rest: `e_I = [(S⁻¹)_II]⁻¹ a_I`
/// (METHOD §2.2).
fn left_out_error(
    root: &Mat<f64>,
    coefficients: &Mat<f64>,
    blocks: &[Range<usize>],
) -> Option<f64> {
    let mut error = 0.0;
    for block in blocks {
        let rows = root.subrows(block.start, block.len());
        let own = rows * rows.transpose();
        let left = own.llt(Side::Lower).ok()?.solve(coefficients.subrows(block.start, block.len()));
        error += left.squared_norm_l2();
    }
    Some(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(n: usize) -> (Mat<f64>, Mat<f64>) {
        let inputs = Mat::from_fn(3, n, |r, i| match r {
            0 => (0.37 * i as f64).sin(),
            1 => (0.61 * i as f64).cos(),
            _ => 5.0,
        });
        let outputs = Mat::from_fn(n, 2, |i, o| {
            let (x, y) = (inputs[(0, i)], inputs[(1, i)]);
            [x * y + 3.0, (2.0 * x).cos() - y][o]
        });
        (inputs, outputs)
    }

    #[test]
    fn blocks_left_out_in_closed_form_equal_fits_without_them() {
        let n = 20;
        let matrix = Mat::from_fn(n, n, |i, j| {
            let d = i as f64 - j as f64;
            (-0.1 * d * d).exp()
        });
        let outputs = Mat::from_fn(n, 2, |i, o| ((i + 3 * o) as f64).sin());
        let (ridge, blocks) = (1e-2, [0..7, 7..12, 12..20]);
        let root = inverse_root(&matrix.self_adjoint_eigen(Side::Lower).unwrap(), ridge);
        let coefficients = &root * (root.transpose() * &outputs);
        let found = left_out_error(&root, &coefficients, &blocks).unwrap();
        let mut expected = 0.0;
        for block in &blocks {
            let kept: Vec<usize> = (0..n).filter(|i| !block.contains(i)).collect();
            let k = kept.len();
            let system = Mat::from_fn(k, k, |i, j| {
                matrix[(kept[i], kept[j])] + if i == j { ridge } else { 0.0 }
            });
            let right = Mat::from_fn(k, 2, |i, o| outputs[(kept[i], o)]);
            let fitted = system.llt(Side::Lower).unwrap().solve(&right);
            for i in block.clone() {
                for o in 0..2 {
                    let predicted: f64 =
                        (0..k).map(|c| matrix[(i, kept[c])] * fitted[(c, o)]).sum();
                    expected += (predicted - outputs[(i, o)]).powi(2);
                }
            }
        }
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn a_smooth_function_is_learned_and_a_constant_input_is_dropped() {
        let (inputs, outputs) = samples(80);
        let blocks: Vec<_> = (0..8).map(|b| 10 * b..10 * b + 10).collect();
        let map = KernelMap::fit(&inputs, &outputs, &blocks).unwrap();
        assert_eq!(map.used, [0, 1]);
        for (x, y) in [(0.3, -0.2), (-0.5, 0.4), (0.1, 0.8)] {
            let found = map.evaluate(&[x, y, 5.0]);
            let expected = [x * y + 3.0, (2.0 * x).cos() - y];
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 0.02, "{found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn samples_that_are_all_alike_have_no_map() {
        let inputs = Mat::from_fn(2, 10, |r, _| r as f64);
        let outputs = Mat::from_fn(10, 1, |i, _| i as f64);
        assert!(KernelMap::fit(&inputs, &outputs, &[0..5, 5..10]).is_none());
    }
}
