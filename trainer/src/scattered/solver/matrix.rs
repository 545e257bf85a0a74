//! Kernels between points: the matrices of every fit.
//!
//! Points are rows, n x d: a column holds one coordinate of all of them, so that a loop over points
//! runs over contiguous memory. Each distance is summed in the order of [`crate::scattered::sum`].

use crate::numeric::columns;
use crate::regression::function::Exact;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Evaluates a kernel between n points and k centres of d coordinates: n x k.
pub fn matrix(kernel: Kernel, points: &Mat<f64>, centres: &Mat<f64>) -> Mat<f64> {
    let mut out = Mat::zeros(points.nrows(), centres.nrows());
    for k in 0..centres.nrows() {
        let column = out.col_as_slice_mut(k);
        add_squared(points, 0, centres, k, column);
        column.iter_mut().for_each(|s| *s = kernel.exact(*s));
    }
    out
}

/// Evaluates a kernel between n points and themselves: n x n, each pair once.
pub fn gram(kernel: Kernel, points: &Mat<f64>) -> Mat<f64> {
    let mut out = Mat::zeros(points.nrows(), points.nrows());
    for k in 0..points.nrows() {
        let column = &mut out.col_as_slice_mut(k)[k..];
        add_squared(points, k, points, k, column);
        column.iter_mut().for_each(|s| *s = kernel.exact(*s));
    }
    mirror(&mut out);
    out
}

/// Copies what is below the diagonal above it, by blocks that stay in the cache.
fn mirror(matrix: &mut Mat<f64>) {
    const BLOCK: usize = 64;
    let n = matrix.nrows();
    for row in (0..n).step_by(BLOCK) {
        for column in (0..=row).step_by(BLOCK) {
            for r in row..n.min(row + BLOCK) {
                for c in column..r.min(column + BLOCK) {
                    matrix[(c, r)] = matrix[(r, c)];
                }
            }
        }
    }
}

/// Measures the distances of points from one of them: of itself, 0, and of all after it.
pub fn distances(points: &Mat<f64>, from: usize) -> Vec<f64> {
    let mut out = vec![0.0; points.nrows() - from];
    add_squared(points, from, points, from, &mut out);
    out.iter_mut().for_each(|s| *s = s.sqrt());
    out
}

/// Adds the squared distances of points, from one of them on, from a centre.
fn add_squared(
    points: &Mat<f64>,
    first: usize,
    centres: &Mat<f64>,
    centre: usize,
    out: &mut [f64],
) {
    columns::narrow_registers();
    for c in 0..points.ncols() {
        let t = centres[(centre, c)];
        for (s, x) in out.iter_mut().zip(&points.col_as_slice(c)[first..]) {
            *s += (x - t) * (x - t);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_the_kernel_of_each_pair() {
        let points = Mat::from_fn(4, 2, |i, c| (i as f64 * 0.7 + c as f64).sin());
        let centres = Mat::from_fn(3, 2, |i, c| (i as f64 * 0.3 - c as f64).cos());
        let found = matrix(Kernel::Matern32, &points, &centres);
        for i in 0..4 {
            for k in 0..3 {
                let [x, y] = [0, 1].map(|c| points[(i, c)] - centres[(k, c)]);
                assert_eq!(found[(i, k)], Kernel::Matern32.exact(x * x + y * y));
            }
        }
        let apart = Mat::from_fn(2, 2, |i, c| (i * (3 + c)) as f64);
        assert_eq!(distances(&apart, 0), [0.0, 5.0]);
        assert_eq!(distances(&apart, 1), [0.0]);
    }

    #[test]
    fn a_gram_matrix_is_the_matrix_of_points_and_themselves() {
        let points = Mat::from_fn(150, 3, |i, c| (i as f64 * 0.7 + c as f64).sin());
        let expected = matrix(Kernel::ThinPlate, &points, &points);
        assert_eq!(gram(Kernel::ThinPlate, &points), expected);
    }
}
