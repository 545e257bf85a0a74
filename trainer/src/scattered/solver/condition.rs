//! The condition of a matrix that is known by its solves alone.

use faer::Mat;

/// Most pairs of solves; more hardly ever change the estimate.
const ROUNDS: usize = 5;

/// Estimates the reciprocal condition in the 1-norm of a matrix of order n and given 1-norm: 1 of an
/// empty one, 0 where a solve overflows.
///
/// The estimate of the inverse's norm is a lower bound, seldom off by more than 3 (Higham, *Accuracy
/// and stability of numerical algorithms*, algorithm 15.4, for one vector).
pub fn reciprocal(
    norm: f64,
    n: usize,
    solve: impl Fn(Mat<f64>) -> Mat<f64>,
    solve_transposed: impl Fn(Mat<f64>) -> Mat<f64>,
) -> f64 {
    if n == 0 {
        return 1.0;
    }
    let mut x = Mat::from_fn(n, 1, |_, _| 1.0 / n as f64);
    let mut inverse_norm = 0.0f64;
    for _ in 0..ROUNDS {
        let y = solve(x.clone());
        let found = y.norm_l1();
        if found <= inverse_norm {
            break;
        }
        inverse_norm = found;
        let signs = Mat::from_fn(n, 1, |i, _| if y[(i, 0)] < 0.0 { -1.0 } else { 1.0 });
        let z = solve_transposed(signs);
        let steepest = (0..n).max_by(|&a, &b| z[(a, 0)].abs().total_cmp(&z[(b, 0)].abs()));
        let along: f64 = (0..n).map(|i| z[(i, 0)] * x[(i, 0)]).sum();
        let Some(steepest) = steepest.filter(|&i| z[(i, 0)].abs() > along) else { break };
        x = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == steepest)));
    }
    // A vector that no cancellation of the rounds above can fool.
    let last = (n - 1).max(1) as f64;
    let alternating =
        |i: usize| (1.0 + i as f64 / last) * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let other = solve(Mat::from_fn(n, 1, |i, _| alternating(i))).norm_l1();
    inverse_norm = inverse_norm.max(2.0 * other / (3.0 * n as f64));
    let reciprocal = 1.0 / norm / inverse_norm;
    if reciprocal.is_finite() { reciprocal.min(1.0) } else { 0.0 }
}

/// Writes a reciprocal condition as errors name it: below f64's precision there is no digit to tell.
pub fn described(rcond: f64) -> String {
    if rcond < f64::EPSILON {
        format!("reciprocal condition below {:.0e}", f64::EPSILON)
    } else {
        format!("reciprocal condition {rcond:.1e}")
    }
}

/// Returns a matrix's 1-norm: the largest sum of a column's magnitudes.
pub fn norm(matrix: faer::MatRef<'_, f64>) -> f64 {
    matrix.col_iter().map(|c| c.norm_l1()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::linalg::solvers::{DenseSolveCore, Solve};

    #[test]
    fn estimates_are_near_the_condition_and_never_below_its_reciprocal() {
        for n in [1, 2, 5, 12] {
            for seed in 0..20 {
                let wave =
                    |i: usize, j: usize| (1.0 + seed as f64 + (7 * i + 3 * j * j) as f64).sin();
                let a = Mat::from_fn(n, n, |i, j| {
                    wave(i, j) + if i == j { 10f64.powi(-(seed % 9)) } else { 0.0 }
                });
                let lu = a.partial_piv_lu();
                let transposed = a.transpose().to_owned().partial_piv_lu();
                let exact = 1.0 / norm(a.as_ref()) / norm(lu.inverse().as_ref());
                let found =
                    reciprocal(norm(a.as_ref()), n, |x| lu.solve(x), |x| transposed.solve(x));
                assert!(found >= 0.999 * exact && found <= 2.0 * exact, "{n} {found} {exact}");
            }
        }
    }

    #[test]
    fn conditions_that_f64_cannot_tell_from_none_are_written_as_below_it() {
        assert_eq!(described(3.4e-9), "reciprocal condition 3.4e-9");
        for rcond in [0.0, 1e-17] {
            assert_eq!(described(rcond), "reciprocal condition below 2e-16");
        }
    }

    #[test]
    fn nothing_is_well_conditioned_and_a_singular_matrix_is_not() {
        let none = |x: Mat<f64>| x;
        assert_eq!(reciprocal(0.0, 0, none, none), 1.0);
        let overflow = |x: Mat<f64>| x * faer::Scale(f64::INFINITY);
        assert_eq!(reciprocal(1.0, 3, overflow, overflow), 0.0);
    }
}
