//! The identities of S0 §3 in f64, on random faces; the reference states differences on other
//! random faces.

use super::common::*;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use serde_json::Value;
use std::path::Path;

/// A prior over N coordinates of rank r, from samples; pins on some coordinates, and blendshapes
/// that span the prior.
struct Edit {
    /// A, N x N.
    a: Mat<f64>,
    /// Eigenvectors and eigenvalues of A that are positive.
    u: Mat<f64>,
    values: Vec<f64>,
    /// Blendshapes, N x r, and the covariance of their weights.
    b: Mat<f64>,
    covariance: Mat<f64>,
    rows: Vec<usize>,
    moved: Vec<f64>,
}

impl Edit {
    fn new(seed: u64) -> Self {
        let (n, r) = (60, 12);
        let mut numbers = Numbers::new(seed);
        let b = numbers.matrix(n, r);
        let samples = numbers.matrix(r, 40);
        let covariance = &samples * samples.transpose() * faer::Scale(1.0 / 40.0);
        let a = &b * &covariance * b.transpose();
        let eigen = a.self_adjoint_eigen(Side::Lower).unwrap();
        let all = eigen.S().column_vector();
        let (u, values) = (eigen.U().subcols(n - r, r).to_owned(), (n - r..n).map(|i| all[i]));
        let values = values.collect();
        let rows = vec![9, 10, 11, 51, 52, 53];
        Self { a, u, values, b, covariance, rows, moved: numbers.list(6) }
    }

    fn pick(&self, of: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(self.rows.len(), of.ncols(), |i, j| of[(self.rows[i], j)])
    }

    fn right(&self) -> Mat<f64> {
        Mat::from_fn(self.moved.len(), 1, |i, _| self.moved[i])
    }

    /// Solves Eq. 10 as it is written: r x r.
    fn primal(&self, beta: f64) -> Vec<f64> {
        let u = self.pick(&self.u);
        let r = self.values.len();
        let prior = Mat::from_fn(r, r, |i, j| if i == j { beta / self.values[i] } else { 0.0 });
        let c = (u.transpose() * &u + prior)
            .llt(Side::Lower)
            .unwrap()
            .solve(u.transpose() * self.right());
        list(&(&self.u * c))
    }

    /// Solves the dual of Eq. 10: k x k.
    fn dual(&self, beta: f64) -> Vec<f64> {
        let r = self.values.len();
        let u = self.pick(&self.u);
        let l = Mat::from_fn(r, r, |i, j| if i == j { self.values[i] } else { 0.0 });
        let kernel = &u * &l * u.transpose() + Mat::<f64>::identity(6, 6) * faer::Scale(beta);
        list(&(&self.u * (l * u.transpose() * kernel.partial_piv_lu().solve(self.right()))))
    }

    /// Solves for weights of the blendshapes.
    fn weights(&self, beta: f64) -> Vec<f64> {
        let b = self.pick(&self.b);
        let zero = vec![0.0; b.ncols()];
        dual(&self.covariance, &b, &[beta; 6], &self.moved, &zero)
    }

    /// Solves Eq. 9 over H_A: f = A x, with the kernel's columns at the pins.
    fn kernel(&self, beta: f64) -> Vec<f64> {
        let at_pins = Mat::from_fn(self.a.nrows(), 6, |i, j| self.a[(i, self.rows[j])]);
        let kernel = self.pick(&at_pins) + Mat::<f64>::identity(6, 6) * faer::Scale(beta);
        list(&(at_pins * kernel.llt(Side::Lower).unwrap().solve(self.right())))
    }

    /// Computes ‖f‖_A by Eq. 5.
    fn norm(&self, f: &[f64]) -> f64 {
        let f = Mat::from_fn(f.len(), 1, |i, _| f[i]);
        let c = self.u.transpose() * f;
        self.values.iter().enumerate().map(|(i, l)| c[(i, 0)].powi(2) / l).sum::<f64>().sqrt()
    }

    fn miss(&self, f: &[f64]) -> f64 {
        let each = self.rows.iter().zip(&self.moved).map(|(row, m)| (f[*row] - m).powi(2));
        (each.sum::<f64>() / 6.0).sqrt()
    }
}

fn list(x: &Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn primal_dual_kernel_and_weights_are_one_solution() {
    for (seed, beta) in (0..5).flat_map(|seed| [1e-6, 1e-4, 1e-2, 1.0].map(|beta| (seed, beta))) {
        let edit = Edit::new(seed);
        let primal = edit.primal(beta);
        let by_weights = edit.weights(beta);
        let w = Mat::from_fn(12, 1, |i, _| by_weights[i]);
        let moved = list(&(&edit.b * w));
        for (name, found, most) in [
            ("dual", edit.dual(beta), 1e-9),
            ("kernel", edit.kernel(beta), 1e-9),
            ("weights", moved, 1e-9),
        ] {
            assert!(apart(&found, &primal) < most, "{name} {beta}: {}", apart(&found, &primal));
        }
        // The norm of the edit equals the norm of the weights: A = B Σ Bᵀ.
        let whitened = solved(&edit.covariance, &by_weights);
        let norm = inner(&by_weights, &whitened).sqrt();
        assert!((norm / edit.norm(&primal) - 1.0).abs() < 1e-8);
        assert!(apart(&edit.primal(2.0 * beta), &primal) > 1e-9, "the measure sees beta");
    }
}

#[test]
fn the_limits_in_beta_are_the_pins_and_nothing() {
    for seed in 0..5 {
        let edit = Edit::new(seed);
        let mut last = (0.0, f64::INFINITY);
        for power in -8..9 {
            let f = edit.kernel(10f64.powi(power));
            // The error at the pins grows, the norm falls.
            let next = (edit.miss(&f), edit.norm(&f));
            assert!(next.0 > last.0 && next.1 < last.1, "{power}: {next:?} {last:?}");
            last = next;
        }
        assert!(edit.miss(&edit.kernel(1e-9)) < 1e-6);
        assert!(edit.norm(&edit.kernel(1e9)) < 1e-6);
    }
}

#[test]
fn the_inner_product_does_not_depend_on_preimages_and_the_kernel_reproduces() {
    for seed in 0..5 {
        let edit = Edit::new(seed);
        let n = edit.a.nrows();
        let mut numbers = Numbers::new(seed + 100);
        let image = |x: &[f64]| list(&(&edit.a * Mat::from_fn(n, 1, |i, _| x[i])));
        let scale = edit.a.norm_max();
        for _ in 0..10 {
            let (x, y, noise) = (numbers.list(n), numbers.list(n), numbers.list(n));
            // Another preimage of A x: x plus a vector in the null space of A.
            let seen = edit.u.transpose() * Mat::from_fn(n, 1, |i, _| noise[i]);
            let seen = list(&(&edit.u * seen));
            let other: Vec<f64> = (0..n).map(|i| x[i] + noise[i] - seen[i]).collect();
            let (f, g) = (image(&x), image(&y));
            assert!(apart(&image(&other), &f) < 1e-12);
            assert!(apart(&other, &x) > 1e-2, "it is another one");
            let size = inner(&x, &f).abs().max(inner(&y, &g).abs());
            assert!((inner(&x, &g) - inner(&other, &g)).abs() < 1e-12 * size);
            assert!((inner(&x, &g) - inner(&f, &y)).abs() < 1e-12 * size);
            // ⟨f, A e_i⟩ = f_i. Eq. 5 is the square: c² / λ.
            for (i, at) in f.iter().enumerate() {
                let e: Vec<f64> = (0..n).map(|j| f64::from(i == j)).collect();
                let column = image(&e);
                assert!((inner(&x, &column) - at).abs() < 1e-12 * size);
                for k in [0, 7, n - 1] {
                    let other: Vec<f64> = (0..n).map(|j| f64::from(k == j)).collect();
                    assert!((inner(&e, &image(&other)) - edit.a[(i, k)]).abs() < 1e-12 * scale);
                }
            }
            assert!((inner(&x, &f) - edit.norm(&f).powi(2)).abs() < 1e-11 * size);
        }
    }
}

#[test]
fn the_prior_finds_its_edit_likelier_than_any_other_of_the_same_pins() {
    for seed in 0..10 {
        let edit = Edit::new(seed);
        let learned = edit.weights(1e-9);
        let zero = [0.0; 12];
        let slider =
            dual(&Mat::identity(12, 12), &edit.pick(&edit.b), &[1e-9; 6], &edit.moved, &zero);
        let moved = |w: &[f64]| list(&(&edit.b * Mat::from_fn(12, 1, |i, _| w[i])));
        assert!(edit.miss(&moved(&learned)) < 1e-6 && edit.miss(&moved(&slider)) < 1e-6);
        assert!(edit.norm(&moved(&learned)) < edit.norm(&moved(&slider)));
        assert!(inner(&slider, &slider) < inner(&learned, &learned));
    }
}

/// The reference's numbers are of another random face; its identities hold for these faces too.
#[test]
fn the_reference_has_the_same_identities() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference");
    let Ok(text) = std::fs::read_to_string(path.join("rkhs_reference.json")) else {
        assert!(std::env::var_os("CI").is_none(), "the reference must be there");
        return;
    };
    let reference: Value = serde_json::from_str(&text).unwrap();
    let direct = &reference["direct_manipulation"];
    let number = |value: &Value| value.as_f64().unwrap();
    let mut last = (0.0, f64::INFINITY);
    for row in direct["rows"].as_array().unwrap() {
        let beta = number(&row["beta"]);
        for name in ["primal_vs_dual", "rkhs_vs_kernel_form", "weight_space_vs_pinv"] {
            assert!(number(&row[name]) < 1e-9);
        }
        let next = (number(&row["pin_error_rms"]), number(&row["norm_A"]));
        assert!(next.0 > last.0 && next.1 < last.1);
        last = next;
        // Our differences do not exceed the reference's, with room.
        let edit = Edit::new(1);
        assert!(apart(&edit.dual(beta), &edit.primal(beta)) < 1e-9);
    }
    let norms = &reference["mahalanobis_of_edit"];
    assert!(number(&norms["learned_prior"]) < number(&norms["slider_norm_2010"]));
    let no_pins = reference["no_pins"].as_array().unwrap();
    assert!(no_pins.iter().all(|x| number(x) == 0.0));
}
