//! Polynomials of a fit: a basis of the monomials' span at the samples (METHOD §2.2).

use crate::scattered::sum::{Term, monomials, powers};
use faer::Mat;

/// Share of a column of unit length below which a pivot is rounding.
pub const RANK_F64: f64 = 1e-10;

/// Polynomials of inputs u, as a basis of rank r.
#[derive(Clone, Debug)]
pub struct Polynomial {
    /// Degree of the polynomials; `None` for no polynomials.
    pub degree: Option<usize>,
    /// Monomials, T, ascending.
    pub terms: Vec<Term>,
    /// Coefficients of the basis on the monomials, T x r, orthonormal.
    pub basis: Mat<f64>,
    /// Values of the basis at the samples, n x r, of rank r.
    pub values: Mat<f64>,
}

/// Samples and inputs of polynomials.
#[derive(Clone, Debug)]
pub struct Space<'a> {
    /// Samples u, n x d.
    pub points: &'a Mat<f64>,
    /// Inputs of the monomials, ascending.
    pub inputs: &'a [usize],
    /// Share of a column below which a pivot is rounding, as [`RANK_F64`].
    pub tolerance: f64,
}

impl Space<'_> {
    /// Makes the polynomials of a degree, or of the highest lower degree whose basis the samples can determine.
    ///
    /// Samples on a plane or on a line keep their degree, with a smaller basis. The degree is lowered only if there are
    /// fewer samples than polynomials on the span of the samples.
    pub fn determined(&self, degree: Option<usize>) -> Polynomial {
        let n = self.points.nrows();
        let affine = self.polynomial(Some(1)).rank();
        let polynomials = |degree: usize| -> usize {
            (1..=degree).fold(1, |product, k| product * (affine - 1 + k) / k)
        };
        let mut found = self.polynomial(degree);
        while let Some(degree) = found.degree
            && polynomials(degree) > n
            && found.rank() == n
        {
            found = self.polynomial(Some(degree - 1));
        }
        found
    }

    /// Makes the polynomials of a degree.
    pub fn polynomial(&self, degree: Option<usize>) -> Polynomial {
        let n = self.points.nrows();
        let Some(degree) = degree else {
            let (basis, values) = (Mat::zeros(0, 0), Mat::zeros(n, 0));
            return Polynomial { degree: None, terms: Vec::new(), basis, values };
        };
        let mut terms = monomials(self.inputs.len(), degree);
        for term in &mut terms {
            if let Term::Product { input, .. } = term {
                *input = self.inputs[*input];
            }
        }
        let mut at_samples = Mat::zeros(n, terms.len());
        for i in 0..n {
            let u: Vec<f64> = self.points.row(i).iter().copied().collect();
            let powers = powers(&terms, &u);
            powers.iter().enumerate().for_each(|(t, power)| at_samples[(i, t)] = *power);
        }
        let basis = basis(&at_samples, self.tolerance);
        let values = &at_samples * &basis;
        Polynomial { degree: Some(degree), terms, basis, values }
    }
}

impl Polynomial {
    /// Returns r.
    pub fn rank(&self) -> usize {
        self.basis.ncols()
    }
}

/// Makes an orthonormal basis of the coefficients that values at samples (n x T) determine, T x r; the identity if they
/// determine all coefficients.
fn basis(at_samples: &Mat<f64>, tolerance: f64) -> Mat<f64> {
    let columns = at_samples.ncols();
    // The inputs' units must not affect rounding.
    let unit = |norm: f64| if norm > 0.0 { 1.0 / norm } else { 0.0 };
    let units: Vec<f64> = at_samples.col_iter().map(|c| unit(c.norm_l2())).collect();
    let scaled = Mat::from_fn(at_samples.nrows(), columns, |i, t| at_samples[(i, t)] * units[t]);
    let decomposed = scaled.col_piv_qr();
    let r = decomposed.thin_R();
    let pivots = r.diagonal().column_vector();
    let rank = pivots.iter().take_while(|pivot| pivot.abs() > tolerance).count();
    if rank == columns {
        return Mat::identity(columns, columns);
    }
    let (order, _) = decomposed.P().arrays();
    let mut rows = Mat::zeros(columns, rank);
    for (place, &column) in order.iter().enumerate() {
        (0..rank.min(place + 1)).for_each(|k| rows[(column, k)] = r[(k, place)]);
    }
    rows.qr().compute_thin_Q()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn of(points: &Mat<f64>, degree: usize) -> Polynomial {
        let inputs: Vec<usize> = (0..points.ncols()).collect();
        Space { points, inputs: &inputs, tolerance: RANK_F64 }.determined(Some(degree))
    }

    fn scattered(n: usize, d: usize) -> Mat<f64> {
        Mat::from_fn(n, d, |i, c| ((1 + i) as f64 * [0.618, 0.414, 0.732][c]).fract() - 0.5)
    }

    /// Returns the largest distance of values at the samples from the span of the basis.
    fn largest_residual(polynomial: &Polynomial, values: &Mat<f64>) -> f64 {
        let q = polynomial.values.qr().compute_thin_Q();
        (values - &q * (q.transpose() * values)).norm_max()
    }

    #[test]
    fn scattered_samples_keep_every_monomial() {
        for scale in [1e-8, 1.0, 1e8] {
            let points = scattered(20, 3) * faer::Scale(scale);
            let found = of(&points, 2);
            assert_eq!((found.degree, found.terms.len(), found.rank()), (Some(2), 10, 10));
        }
    }

    #[test]
    fn a_hinges_nine_entries_have_a_basis_of_rank_three() {
        let points = Mat::from_fn(12, 9, |i, c| {
            let (sine, cosine) = (0.2 * i as f64).sin_cos();
            [cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0][c]
        });
        let found = of(&points, 1);
        assert_eq!((found.degree, found.terms.len(), found.rank()), (Some(1), 10, 3));
        let gram = found.basis.transpose() * &found.basis;
        assert!((gram - Mat::<f64>::identity(3, 3)).norm_max() < 1e-12);
        assert!(largest_residual(&found, &points) < 1e-12, "every entry is in its span");
    }

    #[test]
    fn a_circle_keeps_degree_two_without_one_of_its_monomials() {
        let points = Mat::from_fn(12, 2, |i, c| (0.5 * i as f64 - c as f64 * FRAC_PI_2).cos());
        let found = of(&points, 2);
        assert_eq!((found.degree, found.rank()), (Some(2), 5));
        let square = Mat::from_fn(12, 1, |i, _| points[(i, 0)] * points[(i, 1)]);
        assert!(largest_residual(&found, &square) < 1e-12);
    }

    #[test]
    fn a_degree_is_lowered_only_where_samples_are_too_few() {
        assert_eq!(of(&scattered(5, 2), 2).degree, Some(1), "6 monomials, 5 samples");
        assert_eq!(of(&scattered(6, 2), 2).degree, Some(2));
        assert_eq!(of(&scattered(2, 2), 1).rank(), 2, "along the line between the two");
        let line = Mat::from_fn(4, 2, |i, c| i as f64 * (1.0 + c as f64));
        assert_eq!((of(&line, 2).degree, of(&line, 2).rank()), (Some(2), 3));
        let cube = Mat::from_fn(8, 3, |i, c| f64::from(u8::from(i >> c & 1 == 1)));
        assert_eq!((of(&cube, 2).degree, of(&cube, 2).rank()), (Some(2), 7), "no squares");
        let one = of(&Mat::zeros(1, 2), 2);
        assert_eq!(one.rank(), 1, "a constant");
        assert!(of(&Mat::zeros(3, 1), 1).rank() == 1);
    }

    #[test]
    fn rounding_is_not_a_direction() {
        let rank = |by: f64| {
            let points =
                Mat::from_fn(9, 2, |i, c| i as f64 + by * (c * i) as f64 * (i as f64).sin());
            of(&points, 1).rank()
        };
        assert_eq!((rank(1e-13), rank(1e-8)), (2, 3));
    }
}
