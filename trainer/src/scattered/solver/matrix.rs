//! Kernel matrices between points, and centres chosen by the power function.
//!
//! Points are rows, n x d. A column holds one coordinate of all points, so a loop over points reads contiguous memory.
//! Each distance is summed in the order of [`crate::scattered::sum`].

use crate::numeric::columns;
use crate::regression::function::Exact;
use faer::Mat;
use faer::linalg::solvers::Solve;
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

/// Collects some rows of a matrix.
pub fn some_rows(matrix: &Mat<f64>, rows: &[usize]) -> Mat<f64> {
    Mat::from_fn(rows.len(), matrix.ncols(), |i, c| matrix[(rows[i], c)])
}

/// Copies the lower triangle to the upper, in blocks that fit the cache.
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

/// Measures the distances of a point from itself (0) and from all later points.
pub fn distances(points: &Mat<f64>, from: usize) -> Vec<f64> {
    let mut out = vec![0.0; points.nrows() - from];
    add_squared(points, from, points, from, &mut out);
    out.iter_mut().for_each(|s| *s = s.sqrt());
    out
}

/// Adds the squared distances between a centre and the points from `first` on.
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

/// Share of the first pivot below which the centres determine a sample.
const DETERMINED: f64 = 1e-15;

/// Chooses at most `most` centres by the power function: each next centre is the sample that the earlier centres
/// determine least (METHOD §2.2).
///
/// The first centres are samples that determine the polynomials. The remainder of the kernel is positive definite
/// (Wendland, *Scattered data approximation*, §12.3). Its Cholesky factorisation with the largest pivot first gives the
/// other centres.
///
/// - `points`: n x d.
/// - `polynomials`: values of the polynomials at the points, n x r.
pub fn greedy(
    kernel: Kernel,
    points: &Mat<f64>,
    polynomials: &Mat<f64>,
    most: usize,
) -> Vec<usize> {
    let (n, r) = polynomials.shape();
    let most = most.min(n);
    let first: Vec<usize> = match r {
        0 => Vec::new(),
        _ => polynomials.transpose().to_owned().col_piv_qr().P().arrays().0[..r].to_vec(),
    };
    // Polynomials that are 1 at one of the first samples and 0 at the others, n x r.
    let lagrange = match r {
        0 => Mat::zeros(n, 0),
        _ => {
            let at_first = some_rows(polynomials, &first).transpose().to_owned();
            at_first.partial_piv_lu().solve(polynomials.transpose()).transpose().to_owned()
        }
    };
    let from_first = matrix(kernel, points, &some_rows(points, &first));
    let less = &from_first - &lagrange * some_rows(&from_first, &first);
    let column = |pivot: usize| {
        let at = matrix(kernel, points, &some_rows(points, &[pivot]));
        let own = some_rows(&lagrange, &[pivot]).transpose().to_owned();
        at - &lagrange * some_rows(&from_first, &[pivot]).transpose() - &less * own
    };
    let mut left: Vec<f64> = (0..n)
        .map(|i| {
            let of = |m: &Mat<f64>| (0..r).map(|k| m[(i, k)] * lagrange[(i, k)]).sum::<f64>();
            kernel.exact(0.0) - of(&from_first) - of(&less)
        })
        .collect();
    first.iter().for_each(|&i| left[i] = 0.0);
    let mut order = first;
    order.truncate(most);
    let largest = left.iter().copied().fold(0.0, f64::max);
    let mut factor: Vec<Mat<f64>> = Vec::new();
    while order.len() < most {
        let worst = (0..n).max_by(|&a, &b| left[a].total_cmp(&left[b]).then(b.cmp(&a)));
        let Some(pivot) = worst.filter(|&i| left[i] > DETERMINED * largest) else { break };
        let mut next = column(pivot);
        for known in &factor {
            let at = known[(pivot, 0)];
            next -= known * faer::Scale(at);
        }
        let root = left[pivot].sqrt();
        next *= faer::Scale(1.0 / root);
        left.iter_mut().enumerate().for_each(|(i, left)| *left -= next[(i, 0)] * next[(i, 0)]);
        // Rounding must not choose a centre twice.
        left[pivot] = 0.0;
        order.push(pivot);
        factor.push(next);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::super::polynomial::{RANK_F64, Space};
    use super::super::system::System;
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

    fn points() -> Mat<f64> {
        Mat::from_fn(30, 2, |i, c| ((1 + i) as f64 * [0.618, 0.414][c]).fract())
    }

    fn polynomials(points: &Mat<f64>, degree: Option<usize>) -> Mat<f64> {
        Space { points, inputs: &[0, 1], tolerance: RANK_F64 }.polynomial(degree).values
    }

    /// Returns the power function of centres at a point, by the whole system: the variance there.
    fn power(kernel: Kernel, points: &Mat<f64>, p: &Mat<f64>, centres: &[usize], at: usize) -> f64 {
        let own = Mat::from_fn(centres.len(), 2, |i, c| points[(centres[i], c)]);
        let k = matrix(kernel, &own, &own);
        let p_own = Mat::from_fn(centres.len(), p.ncols(), |i, t| p[(centres[i], t)]);
        let here = Mat::from_fn(1, 2, |_, c| points[(at, c)]);
        let g = matrix(kernel, &own, &here);
        let free = System::new(&k, &p_own);
        let (w, _) = free.solve(&g);
        let weights = w + free.reproducing() * p.subrows(at, 1).transpose()
            - free.inverse() * &k * free.reproducing() * p.subrows(at, 1).transpose();
        let squares = weights.transpose() * &k * &weights;
        kernel.exact(0.0) - 2.0 * (g.transpose() * &weights)[(0, 0)] + squares[(0, 0)]
    }

    #[test]
    fn the_sample_that_is_determined_least_is_next() {
        for (kernel, degree) in
            [(Kernel::Gaussian, None), (Kernel::Matern52, Some(0)), (Kernel::ThinPlate, Some(1))]
        {
            let points = points();
            let p = polynomials(&points, degree);
            let order = greedy(kernel, &points, &p, 9);
            for count in p.ncols().max(1)..9 {
                let of = |at: usize| power(kernel, &points, &p, &order[..count], at);
                let next = of(order[count]);
                let worst = (0..30).map(of).fold(0.0, f64::max);
                assert!(next > 0.0 && next >= worst * (1.0 - 1e-9), "{kernel:?} {count}");
            }
        }
    }

    #[test]
    fn no_sample_is_a_centre_twice() {
        let points = points();
        let mut order = greedy(Kernel::Cubic, &points, &polynomials(&points, Some(1)), 99);
        assert_eq!(order.len(), 30);
        order.sort_unstable();
        order.dedup();
        assert_eq!(order.len(), 30);
        let few = greedy(Kernel::Cubic, &points, &polynomials(&points, Some(1)), 2);
        assert_eq!(few.len(), 2);
    }
}
