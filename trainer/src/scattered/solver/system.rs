//! System of a fit with every sample a centre, its solution and its condition (METHOD §2.2):
//!
//! ```text
//! [K + Λ  P] [c]   [y]
//! [Pᵀ     0] [b] = [0]
//! ```
//!
//! Let P = Q₁ R, and let the columns of Z be orthogonal to Q₁. Then c = Z a, and Zᵀ(K + Λ)Z a = Zᵀ y. This system is
//! positive definite for every kernel whose order the polynomials reach, also for a conditionally positive definite
//! kernel.

use super::matrix::gram;
use super::polynomial::Polynomial;
use super::samples::{OFFSET, ranges};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch as scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj as apply,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj as apply_transposed,
};
use faer::linalg::solvers::{DenseSolveCore, Lblt, Llt, Qr, Solve};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{ColRef, Conj, Mat, MatMut, MatRef, Par, Side};
use sinew_runtime::kernel::Kernel;

/// Residual over the values' range above which the system is solved once more for the residual. This gains a digit at
/// most (*measured*), where few digits are left.
const REFINED: f64 = 1e-12;

/// Solution of a system.
pub struct Solved {
    /// Factors of the system.
    pub system: System,
    /// Polynomials of the fit.
    pub polynomial: Polynomial,
    /// Coefficients of the kernels, n x m.
    pub kernels: Mat<f64>,
    /// Coefficients of the monomials, T x m.
    pub monomials: Mat<f64>,
    /// K + Λ, n x n.
    pub matrix: Mat<f64>,
    /// Residuals of the values, n x m.
    pub residuals: Mat<f64>,
    /// Largest residual of the equations, over the range of the values.
    pub missed: f64,
}

/// Solves for values.
///
/// - `points`: n x d.
/// - `smoothing`: λ of each point, n.
/// - `values`: n x m.
pub fn solve(
    kernel: Kernel,
    points: &Mat<f64>,
    smoothing: &[f64],
    polynomial: Polynomial,
    values: &Mat<f64>,
) -> Solved {
    let mut matrix = gram(kernel, points);
    smoothing.iter().enumerate().for_each(|(i, lambda)| matrix[(i, i)] += lambda);
    let system = System::new(&matrix, &polynomial.values);
    // The rounding of a large offset remains in the equations.
    let offsets = values.col_iter().map(|column| OFFSET * column.norm_max());
    let ranges: Vec<f64> = ranges(values).into_iter().zip(offsets).map(|(r, o)| r.max(o)).collect();
    let of = |(kernels, basis): (Mat<f64>, Mat<f64>)| {
        let error = values - &matrix * &kernels - &polynomial.values * &basis;
        let missed = largest_share(&error, &ranges);
        (kernels, basis, error, missed)
    };
    let mut found = of(system.solve(values));
    if found.3 > REFINED {
        let (kernels, basis) = system.solve(&found.2);
        let refined = of((&found.0 + kernels, &found.1 + basis));
        found = if refined.3 < found.3 { refined } else { found };
    }
    let (kernels, basis, error, missed) = found;
    let residuals = Mat::from_fn(error.nrows(), error.ncols(), |i, o| {
        error[(i, o)] + smoothing[i] * kernels[(i, o)]
    });
    let monomials = &polynomial.basis * basis;
    Solved { system, polynomial, kernels, monomials, matrix, residuals, missed }
}

/// Returns the largest error over the range of its value; infinite for a NaN.
fn largest_share(errors: &Mat<f64>, ranges: &[f64]) -> f64 {
    let of = |(column, range): (ColRef<'_, f64>, &f64)| {
        let share = |error: &f64| if error.is_nan() { f64::INFINITY } else { error.abs() / range };
        column.iter().map(share).fold(0.0, f64::max)
    };
    errors.col_iter().zip(ranges).map(of).fold(0.0, f64::max)
}

/// Factors of a system of n samples and r polynomials.
pub struct System {
    /// QR decomposition of P: Q = [Q₁ Z] and R.
    reflected: Qr<f64>,
    /// Q₁ᵀ(K + Λ)Z, r x (n - r).
    coupling: Mat<f64>,
    /// Factor of Zᵀ(K + Λ)Z.
    factor: Factor,
    /// Reciprocal condition of Zᵀ(K + Λ)Z in the 1-norm.
    rcond: f64,
}

enum Factor {
    Definite(Llt<f64>),
    /// The polynomials are below the kernel's order, or rounding has changed a sign.
    Indefinite(Lblt<f64>),
}

impl System {
    /// Factors K + Λ (n x n, symmetric) and P (n x r, of rank r).
    pub fn new(matrix: &Mat<f64>, polynomials: &Mat<f64>) -> Self {
        let reflected = polynomials.qr();
        let mut turned = matrix.clone();
        reflect(&reflected, turned.as_mut(), Way::Transposed);
        reflect(&reflected, turned.as_mut().transpose_mut(), Way::Transposed);
        let (r, free) = (polynomials.ncols(), polynomials.nrows() - polynomials.ncols());
        let coupling = turned.submatrix(0, r, r, free).to_owned();
        let inner = turned.submatrix(r, r, free, free);
        let factor = match inner.llt(Side::Lower) {
            Ok(factor) => Factor::Definite(factor),
            Err(_) => Factor::Indefinite(inner.lblt(Side::Lower)),
        };
        let solve = |x: Mat<f64>| factor.solve(x);
        let rcond = reciprocal_condition(norm_l1(inner), free, solve, solve);
        Self { reflected, coupling, factor, rcond }
    }

    /// Returns n.
    pub fn sample_len(&self) -> usize {
        self.reflected.Q_basis().nrows()
    }

    /// Returns r.
    pub fn rank(&self) -> usize {
        self.coupling.nrows()
    }

    /// Returns the reciprocal condition of the definite system, in the 1-norm.
    pub fn rcond(&self) -> f64 {
        self.rcond
    }

    /// Solves for the coefficients c (n x m) and b (r x m) of values y (n x m).
    pub fn solve(&self, values: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        let (r, free) = (self.rank(), self.sample_len() - self.rank());
        let mut turned = values.clone();
        reflect(&self.reflected, turned.as_mut(), Way::Transposed);
        let inner = self.factor.solve(turned.subrows(r, free).to_owned());
        let mut polynomials = turned.subrows(0, r) - &self.coupling * &inner;
        solve_upper_triangular_in_place(self.reflected.thin_R(), polynomials.as_mut(), Par::Seq);
        let mut kernels = Mat::zeros(values.nrows(), values.ncols());
        kernels.subrows_mut(r, free).copy_from(&inner);
        reflect(&self.reflected, kernels.as_mut(), Way::Forward);
        (kernels, polynomials)
    }

    /// Computes Z (Zᵀ(K + Λ)Z)⁻¹ Zᵀ, n x n: the block of the system's inverse that maps values to c.
    pub fn inverse(&self) -> Mat<f64> {
        let (n, r) = (self.sample_len(), self.rank());
        let mut out = Mat::zeros(n, n);
        out.submatrix_mut(r, r, n - r, n - r).copy_from(self.factor.inverse());
        reflect(&self.reflected, out.as_mut(), Way::Forward);
        reflect(&self.reflected, out.as_mut().transpose_mut(), Way::Forward);
        out
    }

    /// Computes Q₁, n x r: the span of the polynomials at the samples.
    pub fn span(&self) -> Mat<f64> {
        self.reflected.compute_thin_Q()
    }

    /// Computes Q₁ R⁻ᵀ, n x r: the weights on the samples that reproduce each polynomial of the basis.
    pub fn reproducing(&self) -> Mat<f64> {
        let mut out = self.span();
        let lower = self.reflected.thin_R();
        // X Rᵀ = Q₁ is the same as R Xᵀ = Q₁ᵀ.
        solve_upper_triangular_in_place(lower, out.as_mut().transpose_mut(), Par::Seq);
        out
    }

    /// Computes L⁻¹ Zᵀ x, (n - r) x k, for x (n x k), with L Lᵀ = Zᵀ(K + Λ)Z; `None` if that matrix is indefinite.
    pub fn whitened(&self, x: &Mat<f64>) -> Option<Mat<f64>> {
        let Factor::Definite(factor) = &self.factor else { return None };
        let mut turned = x.clone();
        reflect(&self.reflected, turned.as_mut(), Way::Transposed);
        let mut out = turned.subrows(self.rank(), self.sample_len() - self.rank()).to_owned();
        solve_lower_triangular_in_place(factor.L(), out.as_mut(), Par::Seq);
        Some(out)
    }
}

impl Factor {
    fn solve(&self, mut x: Mat<f64>) -> Mat<f64> {
        match self {
            Self::Definite(factor) => factor.solve_in_place(&mut x),
            Self::Indefinite(factor) => factor.solve_in_place(&mut x),
        }
        x
    }

    fn inverse(&self) -> Mat<f64> {
        match self {
            Self::Definite(factor) => factor.inverse(),
            Self::Indefinite(factor) => factor.inverse(),
        }
    }
}

#[derive(Clone, Copy)]
enum Way {
    /// Multiplies by Q on the left.
    Forward,
    /// Multiplies by Qᵀ on the left.
    Transposed,
}

/// Multiplies a matrix of n rows by Q or Qᵀ, without forming Q.
fn reflect(reflected: &Qr<f64>, matrix: MatMut<'_, f64>, way: Way) {
    let (basis, blocks) = (reflected.Q_basis(), reflected.Q_coeff());
    let mut memory = MemBuffer::new(scratch::<f64>(basis.nrows(), blocks.nrows(), matrix.ncols()));
    let stack = MemStack::new(&mut memory);
    match way {
        Way::Forward => apply(basis, blocks, Conj::No, matrix, Par::Seq, stack),
        Way::Transposed => apply_transposed(basis, blocks, Conj::No, matrix, Par::Seq, stack),
    }
}

/// Largest number of pairs of solves. More pairs hardly ever change the estimate.
const ROUNDS: usize = 5;

/// Estimates the reciprocal condition of a matrix, in the 1-norm; 1 for an empty matrix, 0 if a solve overflows.
///
/// The estimate of the inverse's norm is a lower bound, and seldom wrong by more than a factor of 3 (Higham, *Accuracy
/// and stability of numerical algorithms*, algorithm 15.4, for one vector).
///
/// - `norm`: 1-norm of the matrix.
/// - `n`: order of the matrix.
/// - `solve`, `solve_transposed`: solve for one column.
pub fn reciprocal_condition(
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
    // This vector detects a matrix for which all rounds above cancel.
    let last = (n - 1).max(1) as f64;
    let alternating =
        |i: usize| (1.0 + i as f64 / last) * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let other = solve(Mat::from_fn(n, 1, |i, _| alternating(i))).norm_l1();
    inverse_norm = inverse_norm.max(2.0 * other / (3.0 * n as f64));
    let reciprocal = 1.0 / norm / inverse_norm;
    if reciprocal.is_finite() { reciprocal.min(1.0) } else { 0.0 }
}

/// Returns the 1-norm of a matrix: the largest sum of a column's magnitudes.
pub fn norm_l1(matrix: MatRef<'_, f64>) -> f64 {
    matrix.col_iter().map(|c| c.norm_l1()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::matrix::gram;
    use super::*;
    use faer::linalg::solvers::{DenseSolveCore, Solve};
    use sinew_runtime::kernel::Kernel;

    fn points(n: usize) -> Mat<f64> {
        Mat::from_fn(n, 2, |i, c| ((1 + i) as f64 * [0.618, 0.414][c]).fract())
    }

    /// Solves the whole system by elimination.
    fn eliminated(k: &Mat<f64>, p: &Mat<f64>, y: &Mat<f64>) -> Mat<f64> {
        let (n, r) = p.shape();
        let whole = faer::concat![[k, p], [p.transpose(), Mat::<f64>::zeros(r, r)]];
        whole
            .partial_piv_lu()
            .solve(faer::concat![[y], [Mat::<f64>::zeros(r, y.ncols())]])
            .subrows(0, n + r)
            .to_owned()
    }

    #[test]
    fn solutions_equal_elimination_definite_or_not() {
        for (kernel, r) in [
            (Kernel::Gaussian, 0),
            (Kernel::Gaussian, 1),
            (Kernel::ThinPlate, 3),
            (Kernel::Linear, 0),
            (Kernel::ThinPlate, 1),
        ] {
            let points = points(14);
            let mut k = gram(kernel, &points);
            (0..14).for_each(|i| k[(i, i)] += 1e-3 * i as f64);
            let p = Mat::from_fn(14, r, |i, t| if t == 0 { 1.0 } else { points[(i, t - 1)] });
            let y = Mat::from_fn(14, 2, |i, o| (i as f64 + 0.5 * o as f64).sin());
            let system = System::new(&k, &p);
            let (c, b) = system.solve(&y);
            let expected = eliminated(&k, &p, &y);
            let found = faer::concat![[&c], [&b]];
            assert!((found - &expected).norm_max() < 1e-9 * expected.norm_max(), "{kernel:?} {r}");
            assert!((system.inverse() * &y - &c).norm_max() < 1e-9 * c.norm_max());
            let weights = system.reproducing();
            let identity = Mat::<f64>::identity(r, r);
            assert!((p.transpose() * &weights - &identity).norm_max() < 1e-12);
            let span = system.span();
            assert!((span.transpose() * &span - identity).norm_max() < 1e-12);
            let definite = kernel == Kernel::Gaussian || r == 3;
            let whitened = system.whitened(&y);
            assert_eq!(whitened.is_some(), definite);
            if let Some(half) = whitened {
                let energy = half.transpose() * &half - y.transpose() * &c;
                assert!(energy.norm_max() < 1e-9 * c.norm_max());
            }
        }
    }

    #[test]
    fn as_many_polynomials_as_samples_leave_no_kernels() {
        let p = Mat::from_fn(3, 3, |i, t| (i as f64).powi(t as i32));
        let y = Mat::from_fn(3, 1, |i, _| i as f64 + 1.0);
        let system = System::new(&Mat::identity(3, 3), &p);
        let (c, b) = system.solve(&y);
        assert_eq!((system.rcond(), c.norm_max()), (1.0, 0.0));
        assert!((b - Mat::from_fn(3, 1, |t, _| [1.0, 1.0, 0.0][t])).norm_max() < 1e-12);
        assert_eq!(system.inverse().norm_max(), 0.0);
    }

    #[test]
    fn samples_that_repeat_have_no_condition() {
        let points = Mat::from_fn(6, 2, |i, c| ((1 + i % 5) as f64 * [0.618, 0.414][c]).fract());
        let k = gram(Kernel::Gaussian, &points);
        assert!(System::new(&k, &Mat::zeros(6, 0)).rcond() < 1e-15);
        let mut smoothed = k;
        (0..6).for_each(|i| smoothed[(i, i)] += 0.1);
        assert!(System::new(&smoothed, &Mat::zeros(6, 0)).rcond() > 1e-3);
    }

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
                let exact = 1.0 / norm_l1(a.as_ref()) / norm_l1(lu.inverse().as_ref());
                let found = reciprocal_condition(
                    norm_l1(a.as_ref()),
                    n,
                    |x| lu.solve(x),
                    |x| transposed.solve(x),
                );
                assert!(found >= 0.999 * exact && found <= 2.0 * exact, "{n} {found} {exact}");
            }
        }
    }

    #[test]
    fn an_empty_matrix_is_well_conditioned_and_a_singular_one_is_not() {
        let none = |x: Mat<f64>| x;
        assert_eq!(reciprocal_condition(0.0, 0, none, none), 1.0);
        let overflow = |x: Mat<f64>| x * faer::Scale(f64::INFINITY);
        assert_eq!(reciprocal_condition(1.0, 3, overflow, overflow), 0.0);
    }
}
