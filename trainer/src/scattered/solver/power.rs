//! Samples in the order in which the power function makes them centres: each next one is the sample
//! that those before determine least (METHOD §2.2).
//!
//! The first are samples that determine the polynomials. What they leave of the kernel is positive
//! definite (Wendland, *Scattered data approximation*, §12.3), and its Cholesky factorisation with the
//! largest pivot first gives the others.

use super::matrix::matrix;
use crate::regression::function::Exact;
use faer::Mat;
use faer::linalg::solvers::Solve;
use sinew_runtime::kernel::Kernel;

/// Share of the first pivot below which a sample is determined.
const DETERMINED: f64 = 1e-15;

/// Chooses at most `most` of the points (n x d), of which polynomials have values n x r.
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
    let rows = |m: &Mat<f64>, of: &[usize]| Mat::from_fn(of.len(), m.ncols(), |i, c| m[(of[i], c)]);
    // The polynomials that are 1 at one of the first samples and 0 at the others, n x r.
    let lagrange = match r {
        0 => Mat::zeros(n, 0),
        _ => {
            let at_first = rows(polynomials, &first).transpose().to_owned();
            at_first.partial_piv_lu().solve(polynomials.transpose()).transpose().to_owned()
        }
    };
    let near = rows(points, &first);
    let from_first = matrix(kernel, points, &near);
    let less = &from_first - &lagrange * rows(&from_first, &first);
    let column = |pivot: usize| {
        let at = matrix(kernel, points, &rows(points, &[pivot]));
        let own = rows(&lagrange, &[pivot]).transpose().to_owned();
        at - &lagrange * rows(&from_first, &[pivot]).transpose() - &less * own
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

    fn points() -> Mat<f64> {
        Mat::from_fn(30, 2, |i, c| ((1 + i) as f64 * [0.618, 0.414][c]).fract())
    }

    fn polynomials(points: &Mat<f64>, degree: Option<usize>) -> Mat<f64> {
        Space { points, inputs: &[0, 1], tolerance: RANK_F64 }.polynomial(degree).values
    }

    /// The power function of centres at a point, by the whole system: the variance there.
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
