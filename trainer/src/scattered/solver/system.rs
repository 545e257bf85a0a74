//! The system of a fit with every sample a centre (METHOD §2.2):
//!
//! ```text
//! [K + Λ  P] [c]   [y]
//! [Pᵀ     0] [b] = [0]
//! ```
//!
//! With P = Q₁ R and Z what Q₁ is orthogonal to, c = Z a and Zᵀ(K + Λ)Z a = Zᵀ y: a positive definite
//! system for every kernel whose order the polynomials reach, positive definite or conditionally so.

use super::condition;
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
use faer::{Conj, Mat, MatMut, Par, Side};

/// The factors of a system of n samples and r polynomials.
pub struct System {
    /// Of P: Q = [Q₁ Z] and R.
    reflected: Qr<f64>,
    /// Q₁ᵀ(K + Λ)Z, r x (n - r).
    coupling: Mat<f64>,
    /// Of Zᵀ(K + Λ)Z.
    factor: Factor,
    /// Reciprocal condition of Zᵀ(K + Λ)Z in the 1-norm.
    rcond: f64,
}

enum Factor {
    Definite(Llt<f64>),
    /// Polynomials fall short of the kernel's order, or rounding has left no sign.
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
        let rcond = condition::reciprocal(condition::norm(inner), free, solve, solve);
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

    /// Returns the reciprocal condition of what is solved, in the 1-norm.
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

    /// Computes Z (Zᵀ(K + Λ)Z)⁻¹ Zᵀ, n x n: the block of the system's inverse that turns values into c.
    pub fn inverse(&self) -> Mat<f64> {
        let (n, r) = (self.sample_len(), self.rank());
        let mut out = Mat::zeros(n, n);
        out.submatrix_mut(r, r, n - r, n - r).copy_from(self.factor.inverse());
        reflect(&self.reflected, out.as_mut(), Way::Forward);
        reflect(&self.reflected, out.as_mut().transpose_mut(), Way::Forward);
        out
    }

    /// Computes Q₁, n x r: what polynomials can follow.
    pub fn followed(&self) -> Mat<f64> {
        self.reflected.compute_thin_Q()
    }

    /// Computes Q₁ R⁻ᵀ, n x r: the weights on the samples that reproduce each polynomial of the basis.
    pub fn reproducing(&self) -> Mat<f64> {
        let mut out = self.followed();
        let lower = self.reflected.thin_R();
        // X Rᵀ = Q₁ is R Xᵀ = Q₁ᵀ.
        solve_upper_triangular_in_place(lower, out.as_mut().transpose_mut(), Par::Seq);
        out
    }

    /// Computes L⁻¹ Zᵀ x, (n - r) x k, of x (n x k), with L Lᵀ = Zᵀ(K + Λ)Z; none where that is
    /// indefinite.
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
    /// Q on the left.
    Forward,
    /// Qᵀ on the left.
    Transposed,
}

/// Multiplies a matrix of n rows by Q or Qᵀ, which are never formed.
fn reflect(reflected: &Qr<f64>, matrix: MatMut<'_, f64>, way: Way) {
    let (basis, blocks) = (reflected.Q_basis(), reflected.Q_coeff());
    let mut memory = MemBuffer::new(scratch::<f64>(basis.nrows(), blocks.nrows(), matrix.ncols()));
    let stack = MemStack::new(&mut memory);
    match way {
        Way::Forward => apply(basis, blocks, Conj::No, matrix, Par::Seq, stack),
        Way::Transposed => apply_transposed(basis, blocks, Conj::No, matrix, Par::Seq, stack),
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::gram;
    use super::*;
    use sinew_runtime::kernel::Kernel;

    fn points(n: usize) -> Mat<f64> {
        Mat::from_fn(n, 2, |i, c| ((1 + i) as f64 * [0.618, 0.414][c]).fract())
    }

    /// The whole system, and its solution by elimination.
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
    fn solutions_are_those_of_elimination_definite_or_not() {
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
            let followed = system.followed();
            assert!((followed.transpose() * &followed - identity).norm_max() < 1e-12);
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
    fn as_many_polynomials_as_samples_leave_kernels_nothing() {
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
}
