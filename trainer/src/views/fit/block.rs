//! Outputs of one kind, fitted by one polynomial and one kernel.

use super::candidate::Width;
use super::terms::{Monomial, TermSet, terms};
use crate::scattered::solver::leave_one_out::LeaveOneOut;
use crate::scattered::solver::polynomial::{Polynomial, RANK_F64};
use crate::scattered::solver::solve::solve;
use crate::scattered::sum::{Term, powers};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use serde::Serialize;

/// Least reciprocal condition of a system that is taken.
const RCOND: f64 = 1e-13;
/// Largest share of the values' range by which its equations may be missed.
const MISSED: f64 = 1e-10;

/// Values of n views, and of which each is known.
pub(super) struct Block {
    /// n x m.
    values: Mat<f64>,
    groups: Vec<Group>,
}

/// Values that are known in the same views.
struct Group {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

/// A block's coefficients, and its errors on views that are left out.
pub(super) struct Fitted {
    /// Of the kernels, n x m.
    pub(super) kernels: Mat<f64>,
    /// The monomials, and their coefficients, T x m.
    pub(super) monomials: Vec<Monomial>,
    pub(super) coefficients: Mat<f64>,
    /// What each view is missed by without it; 0 where nothing is known.
    pub(super) errors: Mat<f64>,
    known: usize,
    /// Whether all views could be left out.
    pub(super) is_determined: bool,
}

/// How well views are predicted by the others.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LeftOutViews {
    /// RMS over the coordinates of all.
    pub rms: f64,
    /// The same by view.
    pub each: Vec<f64>,
}

impl Block {
    /// Takes values by view, none where they are not known.
    pub(super) fn new(values: &[Vec<Option<f64>>]) -> Self {
        let (n, m) = (values.len(), values.first().map_or(0, Vec::len));
        let mut groups: Vec<Group> = Vec::new();
        for column in 0..m {
            let is_known = |own: &Vec<Option<f64>>| own.get(column).is_some_and(Option::is_some);
            let rows: Vec<usize> = (0..n).filter(|&i| is_known(&values[i])).collect();
            match groups.iter_mut().find(|group| group.rows == rows) {
                Some(group) => group.columns.push(column),
                None => groups.push(Group { rows, columns: vec![column] }),
            }
        }
        let values = Mat::from_fn(n, m, |i, c| values[i][c].unwrap_or_default());
        Self { values, groups }
    }

    /// Fits views at points (n x d, scaled by the width) with a polynomial, and kernels or none; none where
    /// rounding decides.
    pub(super) fn fit(
        &self,
        points: &Mat<f64>,
        set: &TermSet,
        width: Option<Width>,
    ) -> Option<Fitted> {
        let (monomials, list) = terms(&set.monomials);
        let (n, m) = self.values.shape();
        let mut out = Fitted {
            kernels: Mat::zeros(n, m),
            coefficients: Mat::zeros(monomials.len(), m),
            errors: Mat::zeros(n, m),
            known: self.groups.iter().map(|group| group.rows.len() * group.columns.len()).sum(),
            is_determined: true,
            monomials,
        };
        for Group { rows, columns } in &self.groups {
            let pick = |of: &Mat<f64>, columns: &[usize]| {
                Mat::from_fn(rows.len(), columns.len(), |i, c| of[(rows[i], columns[c])])
            };
            let features: Vec<usize> = (0..points.ncols()).collect();
            let (own, values) = (pick(points, &features), pick(&self.values, columns));
            let polynomial = determined(&own, &list);
            let (kernels, coefficients, left_out) = match width {
                Some(width) => with_kernels(width, &own, polynomial, &values)?,
                None => alone(&polynomial, &values),
            };
            for (c, &column) in columns.iter().enumerate() {
                rows.iter()
                    .enumerate()
                    .for_each(|(i, &r)| out.kernels[(r, column)] = kernels[(i, c)]);
                let own = coefficients.col(c);
                out.coefficients.col_mut(column).copy_from(own);
            }
            for (i, &row) in rows.iter().enumerate() {
                let Some(errors) = left_out.errors(&[i]) else {
                    out.is_determined = false;
                    continue;
                };
                for (c, &column) in columns.iter().enumerate() {
                    out.errors[(row, column)] = errors[(0, c)];
                }
            }
        }
        Some(out)
    }
}

impl Fitted {
    /// Returns the RMS error of views that are left out; none where they cannot be, or of no values.
    pub(super) fn left_out(&self) -> Option<f64> {
        let rms = (self.errors.squared_norm_l2() / self.known as f64).sqrt();
        Some(rms).filter(|rms| self.is_determined && rms.is_finite())
    }

    /// Reports the errors by view.
    pub(super) fn report(&self) -> Option<LeftOutViews> {
        let per_view = self.errors.ncols() as f64;
        let each = self.errors.row_iter().map(|row| (row.squared_norm_l2() / per_view).sqrt());
        Some(LeftOutViews { rms: self.left_out()?, each: each.collect() })
    }
}

type Coefficients = (Mat<f64>, Mat<f64>, LeaveOneOut);

fn with_kernels(
    width: Width,
    points: &Mat<f64>,
    polynomial: Polynomial,
    values: &Mat<f64>,
) -> Option<Coefficients> {
    let smoothing = vec![0.0; points.nrows()];
    let solved = solve(width.kernel, points, &smoothing, polynomial, values);
    let free = solved.system.sample_len() > solved.system.rank();
    if free && solved.system.rcond() < RCOND || solved.missed > MISSED {
        return None;
    }
    let left_out = LeaveOneOut::of_solved(&solved, &smoothing);
    Some((solved.kernels, solved.monomials, left_out))
}

/// Makes the polynomials that views tell apart, of monomials by ascending degree: one that follows from those
/// before it is left out, so that no view between two others is made of products that none of them shows.
fn determined(points: &Mat<f64>, terms: &[Term]) -> Polynomial {
    let n = points.nrows();
    let mut all = Mat::zeros(n, terms.len());
    for i in 0..n {
        let u: Vec<f64> = points.row(i).iter().copied().collect();
        powers(terms, &u).iter().enumerate().for_each(|(t, power)| all[(i, t)] = *power);
    }
    let (mut kept, mut directions): (Vec<usize>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    for t in 0..terms.len() {
        let mut rest: Vec<f64> = all.col(t).iter().copied().collect();
        let norm = |of: &[f64]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
        let whole = norm(&rest);
        // Twice is enough to be orthogonal.
        for direction in directions.iter().chain(&directions) {
            let along: f64 = direction.iter().zip(&rest).map(|(d, x)| d * x).sum();
            rest.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
        }
        let left = norm(&rest);
        if left > RANK_F64 * whole && left > 0.0 {
            rest.iter_mut().for_each(|x| *x /= left);
            directions.push(rest);
            kept.push(t);
        }
    }
    Polynomial {
        degree: None,
        terms: terms.to_vec(),
        basis: Mat::from_fn(terms.len(), kept.len(), |t, r| f64::from(u8::from(kept[r] == t))),
        values: Mat::from_fn(n, kept.len(), |i, r| all[(i, kept[r])]),
    }
}

/// Fits a polynomial by least squares.
fn alone(polynomial: &Polynomial, values: &Mat<f64>) -> Coefficients {
    let qr = polynomial.values.qr();
    let basis = qr.solve_lstsq(values);
    let residuals = values - &polynomial.values * &basis;
    let left_out = LeaveOneOut::of_hat(qr.compute_thin_Q(), residuals);
    (Mat::zeros(values.nrows(), values.ncols()), &polynomial.basis * basis, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattered::sum::monomials;

    #[test]
    fn products_that_no_view_shows_are_left_out() {
        // A smile, an open jaw, never both: x y follows from 1, x and y.
        let points = Mat::from_fn(3, 2, |i, c| [[-0.4, -0.3], [0.6, -0.3], [-0.4, 0.7]][i][c]);
        let found = determined(&points, &monomials(2, 2));
        assert_eq!((found.rank(), found.terms.len()), (3, 6));
        assert!((0..6).all(|t| (found.basis.row(t).norm_max() > 0.0) == (t < 3)));
    }
}
