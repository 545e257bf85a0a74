//! Sum of kernels and a polynomial: `f(x) = Σ_k c_k G(|z - t_k|²) + p(u)` (METHOD §2).

use crate::regression::function::Exact;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Function of d inputs with m values: a sum of kernels and of a polynomial.
///
/// Inputs x are shifted and scaled to u. Distances are measured in z, which is u or the product of u with a metric W.
#[derive(Clone, Debug)]
pub struct KernelSum {
    /// Kernel G.
    pub kernel: Kernel,
    /// Shift of each input, d: subtracted first.
    pub shift: Vec<f64>,
    /// Scale of each shifted input, d.
    pub scale: Vec<f64>,
    /// Metric W, e x d; `None` if z is u.
    pub metric: Option<Mat<f64>>,
    /// Centres t, a column each: d x n, or e x n.
    pub centres: Mat<f64>,
    /// Monomials of p, ascending: 1 first.
    pub terms: Vec<Term>,
    /// Coefficients `[c b]`, m x (n + terms).
    pub coefficients: Mat<f64>,
}

/// Monomial of u.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// The constant 1.
    One,
    /// Product of an earlier monomial and an input.
    Product {
        /// Index of the earlier monomial.
        earlier: usize,
        /// Index of the input.
        input: usize,
    },
}

/// Lists the monomials of d inputs up to a degree, by ascending degree.
pub fn monomials(inputs: usize, degree: usize) -> Vec<Term> {
    let mut terms = vec![Term::One];
    // Last input of each monomial of the previous degree.
    let mut last = vec![(0, 0)];
    for _ in 0..degree {
        let mut next = Vec::new();
        for (earlier, from) in last {
            for input in from..inputs {
                next.push((terms.len(), input));
                terms.push(Term::Product { earlier, input });
            }
        }
        last = next;
    }
    terms
}

/// Evaluates monomials.
pub fn powers(terms: &[Term], u: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::with_capacity(terms.len());
    for term in terms {
        out.push(match *term {
            Term::One => 1.0,
            Term::Product { earlier, input } => out[earlier] * u[input],
        });
    }
    out
}

impl KernelSum {
    /// Returns m.
    pub fn value_len(&self) -> usize {
        self.coefficients.nrows()
    }

    /// Returns u of inputs x.
    pub fn scaled(&self, x: &[f64]) -> Vec<f64> {
        let scaled = x.iter().zip(&self.shift).zip(&self.scale);
        scaled.map(|((x, shift), scale)| (x - shift) * scale).collect()
    }

    /// Returns z of u.
    pub fn measured(&self, u: &[f64]) -> Vec<f64> {
        match &self.metric {
            None => u.to_vec(),
            Some(w) => (0..w.nrows())
                .map(|r| u.iter().enumerate().map(|(i, u)| w[(r, i)] * u).sum())
                .collect(),
        }
    }

    /// Evaluates the basis functions of the coefficients at d inputs: the kernels, n, and the monomials, T.
    pub fn basis(&self, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let u = self.scaled(x);
        let z = self.measured(&u);
        let kernels = self.squared_distances(&z).map(|s| self.kernel.exact(s));
        (kernels.collect(), powers(&self.terms, &u))
    }

    /// Lists the squared distances of z from the centres, n.
    pub fn squared_distances(&self, z: &[f64]) -> impl Iterator<Item = f64> {
        self.centres.col_iter().map(|t| squared(z, t.iter()))
    }

    /// Evaluates the function at d inputs: m values.
    pub fn evaluate(&self, x: &[f64]) -> Vec<f64> {
        let (kernels, powers) = self.basis(x);
        let mut out = vec![0.0; self.value_len()];
        for (column, value) in self.coefficients.col_iter().zip(kernels.iter().chain(&powers)) {
            out.iter_mut().zip(column.iter()).for_each(|(out, c)| *out += c * value);
        }
        out
    }

    /// Computes the derivatives of the values by the inputs, m x d (METHOD §3: (x - t) G' is 0 on a centre).
    pub fn jacobian(&self, x: &[f64]) -> Mat<f64> {
        let u = self.scaled(x);
        let z = self.measured(&u);
        let (m, d, n) = (self.value_len(), u.len(), self.centres.ncols());
        let mut by_z = Mat::<f64>::zeros(m, z.len());
        for k in 0..n {
            let slope = 2.0 * self.kernel.slope(squared(&z, self.centres.col(k).iter()));
            for (i, z) in z.iter().enumerate() {
                let step = slope * (z - self.centres[(i, k)]);
                (0..m).for_each(|o| by_z[(o, i)] += self.coefficients[(o, k)] * step);
            }
        }
        let mut out = match &self.metric {
            None => by_z,
            Some(w) => by_z * w,
        };
        let powers = powers(&self.terms, &u);
        for input in 0..d {
            let mut slopes: Vec<f64> = Vec::with_capacity(powers.len());
            for term in &self.terms {
                slopes.push(match *term {
                    Term::One => 0.0,
                    Term::Product { earlier, input: by } => {
                        slopes[earlier] * u[by] + if by == input { powers[earlier] } else { 0.0 }
                    }
                });
            }
            for (t, slope) in slopes.iter().enumerate() {
                (0..m).for_each(|o| out[(o, input)] += self.coefficients[(o, n + t)] * slope);
            }
            (0..m).for_each(|o| out[(o, input)] *= self.scale[input]);
        }
        out
    }
}

/// Returns |a - b|².
pub(super) fn squared<'a>(a: &[f64], b: impl Iterator<Item = &'a f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kernel: Kernel, metric: Option<Mat<f64>>) -> KernelSum {
        let terms = monomials(3, 2);
        let wave = |r: usize, c: usize| (1.3 * r as f64 + 0.7 * c as f64 + 0.2).sin();
        KernelSum {
            kernel,
            shift: vec![0.1, -0.3, 0.2],
            scale: vec![0.4, 0.5, 0.3],
            centres: Mat::from_fn(metric.as_ref().map_or(3, Mat::nrows), 5, wave),
            metric,
            coefficients: Mat::from_fn(2, 5 + terms.len(), |r, c| wave(c, r + 1)),
            terms,
        }
    }

    #[test]
    fn monomials_are_all_products_once() {
        assert_eq!(monomials(3, 0).len(), 1);
        assert_eq!(monomials(3, 2).len(), 10);
        assert_eq!(monomials(2, 5).len(), 21);
        let mut values = powers(&monomials(2, 3), &[2.0, 3.0]);
        values.sort_by(f64::total_cmp);
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 9.0, 12.0, 18.0, 27.0]);
    }

    #[test]
    fn the_jacobian_is_the_differences_of_the_values() {
        let metric = Mat::from_fn(2, 3, |r, c| [[0.8, -0.3, 0.2], [0.1, 0.5, -0.6]][r][c]);
        for kernel in Kernel::ALL {
            for metric in [None, Some(metric.clone())] {
                let sum = sum(kernel, metric);
                let x = [0.35, -0.2, 0.6];
                let found = sum.jacobian(&x);
                for input in 0..3 {
                    let at = |h: f64| {
                        let mut x = x;
                        x[input] += h;
                        sum.evaluate(&x)
                    };
                    let (after, before) = (at(1e-5), at(-1e-5));
                    for o in 0..2 {
                        let expected = (after[o] - before[o]) / 2e-5;
                        assert!((found[(o, input)] - expected).abs() < 1e-8, "{kernel:?}");
                    }
                }
            }
        }
    }
}
