//! Inputs of a kernel fit (METHOD §2.2): distances between samples, kernel widths relative to them, and kernel centres.
//!
//! Centres are chosen greedily by the power function. The next centre is the sample that the earlier centres explain
//! worst. This is the Cholesky factorisation of the kernel matrix with the largest pivot first, so the factor of every
//! prefix of the centres is part of the factor of all.
//!
//! The first centre is the origin, the rest pose. The basis function of the origin is left out, so all other basis
//! functions vanish at rest.

use super::function::Exact;
use crate::numeric::columns;
use faer::{Mat, MatRef};
use sinew_runtime::envelope::GroupKernel;

/// Candidate squared widths, in median squared distances of the samples.
pub const WIDTHS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Share of the linear kernel beside the other kernel, over the median squared distance.
const LINEAR: f64 = 0.2;

/// Samples of a regression: n samples of d inputs.
pub struct Inputs {
    values: Mat<f64>,
    /// Inner products of the origin and the samples, n + 1 x n + 1.
    products: Mat<f64>,
    median: f64,
}

impl Inputs {
    /// Takes inputs d x n, zero at rest; `None` if all samples are equal.
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

    /// Returns the matrix of `G + 0.2 x·x'/m`, conditioned on a value of 0 at the origin, n x n.
    ///
    /// This is the kernel of a regression in which every sample is a centre.
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

    /// Returns the squared distance of two points: point 0 is the origin, point 1 + i is sample i.
    pub(super) fn squared(&self, i: usize, j: usize) -> f64 {
        let p = &self.products;
        (p[(i, i)] + p[(j, j)] - 2.0 * p[(i, j)]).max(0.0)
    }

    /// Converts a squared width from median squared distances to squared units of the inputs.
    pub(super) fn squared_width(&self, width: f64) -> f64 {
        width * self.median
    }

    /// Returns the factor of inner products of inputs in the linear kernel.
    pub(super) fn linear_share(&self) -> f64 {
        LINEAR / self.median
    }
}

/// Unexplained share of a sample below which the sample is no centre.
const UNEXPLAINED_SHARE: f64 = 1e-15;

/// Centres in the order of their choice, with the Cholesky factor of their kernel matrix.
pub struct GreedyCentres {
    /// Samples that became centres after the origin.
    pub order: Vec<usize>,
    /// Cholesky factor. Rows: the origin, then the n samples; columns: the origin, then the centres.
    factor: Mat<f64>,
    /// Kernel values, with the rows and columns of the factor.
    values: Mat<f64>,
}

impl GreedyCentres {
    /// Chooses at most `most` of the samples.
    ///
    /// - `squared`: scaled squared distance of two points: point 0 is the origin, point 1 + i is sample i.
    pub fn new(
        kernel: GroupKernel,
        len: usize,
        most: usize,
        squared: impl Fn(usize, usize) -> f64,
    ) -> Self {
        columns::narrow_registers();
        let points = len + 1;
        let mut factor = Mat::<f64>::zeros(points, most.min(len) + 1);
        let mut values = factor.clone();
        let mut left = vec![1.0; points];
        let (mut order, mut pivot) = (Vec::new(), 0);
        for column in 0..factor.ncols() {
            let root = f64::sqrt(left[pivot]);
            let before = factor.subcols(0, column);
            let explained = before * before.row(pivot).transpose();
            for point in 0..points {
                let here = kernel.exact(squared(point, pivot));
                let value = (here - explained[point]) / root;
                values[(point, column)] = here;
                factor[(point, column)] = value;
                left[point] -= value * value;
            }
            // Rounding must not choose a centre twice.
            left[pivot] = 0.0;
            if column > 0 {
                order.push(pivot - 1);
            }
            let worst = (1..points).max_by(|&a, &b| left[a].total_cmp(&left[b]).then(b.cmp(&a)));
            match worst.filter(|&point| left[point] > UNEXPLAINED_SHARE) {
                Some(point) => pivot = point,
                None => break,
            }
        }
        let taken = |of: Mat<f64>| of.subcols(0, order.len() + 1).to_owned();
        Self { factor: taken(factor), values: taken(values), order }
    }

    /// Returns the first `count` centres only.
    pub fn first(&self, count: usize) -> Self {
        let taken = |of: &Mat<f64>| of.subcols(0, count + 1).to_owned();
        let (factor, values) = (taken(&self.factor), taken(&self.values));
        Self { order: self.order[..count].to_vec(), factor, values }
    }

    /// Returns the kernel value of a centre at a point.
    ///
    /// - `point`: 0 for the origin, 1 + i for sample i.
    /// - `centre`: 0 for the origin, 1 + k for centre k.
    pub fn value(&self, point: usize, centre: usize) -> f64 {
        self.values[(point, centre)]
    }

    /// Returns the values of the centres' orthonormal functions at the n samples, n x centres.
    pub fn functions(&self) -> MatRef<'_, f64> {
        self.factor.submatrix(1, 1, self.factor.nrows() - 1, self.order.len())
    }

    /// Converts coefficients of the orthonormal functions (centres x r) into coefficients of the kernels at the origin
    /// and at the centres (centres + 1 x r).
    pub fn at_centres(&self, coefficients: &Mat<f64>) -> Mat<f64> {
        let count = coefficients.nrows();
        let row = |k: usize| if k == 0 { 0 } else { self.order[k - 1] + 1 };
        let triangle = Mat::from_fn(count + 1, count + 1, |r, c| self.factor[(row(r), c)]);
        let mut out = Mat::zeros(count + 1, coefficients.ncols());
        out.subrows_mut(1, count).copy_from(coefficients);
        let upper = triangle.transpose();
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(
            upper,
            out.as_mut(),
            faer::Par::Seq,
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_samples_have_no_median() {
        assert!(Inputs::new(Mat::from_fn(2, 10, |r, _| r as f64)).is_none());
    }

    #[test]
    fn the_kernel_is_zero_at_rest() {
        let inputs = Mat::from_fn(2, 4, |r, i| if i == 0 { 0.0 } else { (r + i) as f64 });
        let kernel = Inputs::new(inputs).unwrap().kernel_matrix(GroupKernel::Gaussian, 4.0);
        assert!((0..4).all(|i| kernel[(0, i)].abs() < 1e-15) && kernel[(1, 1)] > 0.1);
    }

    fn line(n: usize) -> (Vec<f64>, impl Fn(usize, usize) -> f64) {
        let at = move |i: usize| if i == 0 { 0.0 } else { 0.3 + 0.1 * i as f64 };
        ((1..=n).map(at).collect(), move |a, b| (at(a) - at(b)).powi(2))
    }

    #[test]
    fn the_worst_explained_sample_is_next() {
        let (_, squared) = line(20);
        let greedy = GreedyCentres::new(GroupKernel::Gaussian, 20, 3, squared);
        assert_eq!(greedy.order[0], 19, "the farthest from the origin");
        assert!((5..12).contains(&greedy.order[1]), "then between the two");
        let mut twice = greedy.order.clone();
        twice.dedup();
        assert_eq!(twice.len(), 3);
    }

    #[test]
    fn functions_are_sums_of_kernels_and_vanish_at_the_origin() {
        let (x, squared) = line(20);
        let greedy = GreedyCentres::new(GroupKernel::Matern32, 20, 6, squared);
        let given = Mat::from_fn(6, 2, |r, c| (r as f64 - 2.0 * c as f64).sin());
        let coefficients = greedy.at_centres(&given);
        let value = |at: f64, o: usize| -> f64 {
            (0..7)
                .map(|k| {
                    let centre = if k == 0 { 0.0 } else { x[greedy.order[k - 1]] };
                    coefficients[(k, o)] * GroupKernel::Matern32.exact((at - centre).powi(2))
                })
                .sum()
        };
        let expected = greedy.functions() * &given;
        for (i, &x) in x.iter().enumerate() {
            for o in 0..2 {
                assert!((value(x, o) - expected[(i, o)]).abs() < 1e-12);
            }
        }
        assert!(value(0.0, 0).abs() < 1e-12 && value(0.0, 1).abs() < 1e-12);
        assert!(value(0.5, 0).abs() > 1e-3);
    }

    #[test]
    fn samples_that_repeat_are_one_centre() {
        let at = |i: usize| if i == 0 { 0.0 } else { 1.0 + (i % 3) as f64 };
        let greedy =
            GreedyCentres::new(GroupKernel::Gaussian, 12, 12, |a, b| (at(a) - at(b)).powi(2));
        assert_eq!(greedy.order.len(), 3);
    }
}
