//! The inputs of a kernel fit: how far samples are from each other and from the origin, and what is
//! measured in that, widths and the linear kernel (METHOD §2.2).

use super::function::Exact;
use faer::Mat;
use sinew_runtime::envelope::GroupKernel;

/// Candidate squared widths, in median squared distances of the samples.
pub const WIDTHS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Share of the linear kernel beside the other, over the median squared distance.
const LINEAR: f64 = 0.2;

/// n samples of d inputs.
pub struct Inputs {
    values: Mat<f64>,
    /// Inner products of the origin and the samples, n + 1 x n + 1.
    products: Mat<f64>,
    median: f64,
}

impl Inputs {
    /// Takes inputs d x n, zero at rest; none where they are all alike.
    pub fn new(values: Mat<f64>) -> Option<Self> {
        let n = values.ncols();
        let with_origin = faer::concat![[Mat::<f64>::zeros(values.nrows(), 1), &values]];
        let products = with_origin.transpose() * &with_origin;
        let mut inputs = Self { values, products, median: 0.0 };
        let pairs = (1..=n).flat_map(|i| (1..i).map(move |j| (i, j)));
        let mut distances: Vec<f64> =
            pairs.map(|(i, j)| inputs.squared(i, j)).filter(|&d| d > 0.0).collect();
        if distances.is_empty() {
            return None;
        }
        let middle = distances.len() / 2;
        inputs.median = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
        Some(inputs)
    }

    /// Returns n.
    pub fn sample_len(&self) -> usize {
        self.values.ncols()
    }

    /// Returns d.
    pub fn input_len(&self) -> usize {
        self.values.nrows()
    }

    /// Returns the inputs multiplied by a factor, d x n.
    pub fn scaled(&self, factor: f64) -> Mat<f64> {
        &self.values * faer::Scale(factor)
    }

    /// Returns the matrix of `G + 0.2 x·x'/m` conditioned on being zero at the origin, n x n: the
    /// kernel of a regression in which every sample is a centre.
    pub fn kernel_matrix(&self, kernel: GroupKernel, width: f64) -> Mat<f64> {
        let (n, scale) = (self.sample_len(), 1.0 / self.squared_width(width));
        let value = |i: usize, j: usize| kernel.exact(scale * self.squared(i, j));
        let rest: Vec<f64> = (1..=n).map(|i| value(0, i)).collect();
        Mat::from_fn(n, n, |i, j| {
            value(i + 1, j + 1) - rest[i] * rest[j]
                + self.linear_share() * self.products[(i + 1, j + 1)]
        })
    }

    /// Returns the inputs, d x n.
    pub(super) fn values(&self) -> &Mat<f64> {
        &self.values
    }

    /// Returns the squared distance of two points: number 0 is the origin, 1 + i sample i.
    pub(super) fn squared(&self, i: usize, j: usize) -> f64 {
        let p = &self.products;
        (p[(i, i)] + p[(j, j)] - 2.0 * p[(i, j)]).max(0.0)
    }

    /// Turns a squared width in median squared distances to one of inputs.
    pub(super) fn squared_width(&self, width: f64) -> f64 {
        width * self.median
    }

    /// Returns what inner products of inputs are multiplied by in the linear kernel.
    pub(super) fn linear_share(&self) -> f64 {
        LINEAR / self.median
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_that_are_all_alike_have_no_median() {
        assert!(Inputs::new(Mat::from_fn(2, 10, |r, _| r as f64)).is_none());
    }

    #[test]
    fn the_kernel_is_zero_at_rest() {
        let inputs = Mat::from_fn(2, 4, |r, i| if i == 0 { 0.0 } else { (r + i) as f64 });
        let kernel = Inputs::new(inputs).unwrap().kernel_matrix(GroupKernel::Gaussian, 4.0);
        assert!((0..4).all(|i| kernel[(0, i)].abs() < 1e-15) && kernel[(1, 1)] > 0.1);
    }
}
