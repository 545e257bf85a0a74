//! Fits outputs of one kind by one polynomial and one kernel, and lists the polynomials and kernels to try.

use super::map::with_features;
use crate::regression::function::{by_name, order};
use crate::scattered::model::{Input, InputKind};
use crate::scattered::solver::leave_one_out::LeaveOneOut;
use crate::scattered::solver::polynomial::{Polynomial, RANK_F64};
use crate::scattered::solver::system::solve;
use crate::scattered::sum::{Term, powers};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use serde::Serialize;
use sinew_runtime::kernel::Kernel;

/// Smallest accepted reciprocal condition of a system.
const RCOND: f64 = 1e-13;
/// Largest accepted residual of the equations, over the range of the values.
const MISSED: f64 = 1e-10;

/// Values of n views, grouped by the views in which they are known.
pub(super) struct Block {
    /// Values, n x m; 0 where unknown.
    values: Mat<f64>,
    groups: Vec<Group>,
}

/// Columns that are known in the same views.
struct Group {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

/// Coefficients of a block, and its errors on left-out views.
pub(super) struct Fitted {
    /// Coefficients of the kernels, n x m.
    pub(super) kernels: Mat<f64>,
    /// The T monomials, and their coefficients, T x m.
    pub(super) monomials: Vec<Monomial>,
    pub(super) coefficients: Mat<f64>,
    /// Error of each view when it is left out, n x m; 0 where unknown.
    pub(super) errors: Mat<f64>,
    known: usize,
    /// Whether every view could be left out.
    pub(super) is_determined: bool,
}

/// Errors of views that are predicted from the others.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LeftOutViews {
    /// RMS error over the coordinates of all views.
    pub rms: f64,
    /// RMS error of each view.
    pub each: Vec<f64>,
}

impl Block {
    /// Makes a block of values by view; `None` where unknown.
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

    /// Fits the views with a polynomial, and with kernels if `width` is given. Returns `None` if rounding dominates.
    ///
    /// - `points`: features of the views, n x d, scaled by the width.
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
    /// Returns the RMS error of left-out views. `None` if a view cannot be left out, or if no value is known.
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

/// Selects the monomials that the views distinguish, by ascending degree. A monomial that depends linearly on earlier
/// monomials is dropped. Products that no training view shows then do not shape the views between.
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
        // Two passes of Gram-Schmidt are enough for orthogonality.
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

/// Shape parameters to try: one over the width, in mean distances of the views.
const EPSILONS: [f64; 10] = [0.125, 0.177, 0.25, 0.354, 0.5, 0.707, 1.0, 1.414, 2.0, 4.0];
/// Kernels without a width.
const PLAIN: [Kernel; 3] = [Kernel::Linear, Kernel::ThinPlate, Kernel::Cubic];

/// A polynomial with or without kernels, and its error on left-out views.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Name of the polynomial.
    pub polynomial: &'static str,
    /// The kernel and its shape parameter, if there are kernels.
    pub kernel: Option<Width>,
    /// RMS error on left-out views; `None` if the other views do not determine a fit.
    pub left_out: Option<f64>,
}

/// A kernel and its shape parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Width {
    /// Kernel G.
    #[serde(serialize_with = "by_name")]
    pub kernel: Kernel,
    /// Factor of distances. The mean distance of the views is 1.
    pub epsilon: f64,
}

impl Width {
    /// Piecewise linear interpolation, for outputs without a choice.
    pub(super) const LINEAR: Self = Self { kernel: Kernel::Linear, epsilon: 1.0 };

    /// Lists the kernels that can accompany a polynomial.
    pub(super) fn all(set: &TermSet) -> Vec<Self> {
        let reached = |kernel: &Kernel| set.is_whole || order(*kernel).is_some_and(|o| o <= 1);
        let plain = PLAIN.into_iter().filter(reached).map(|kernel| Self { kernel, epsilon: 1.0 });
        let of = |epsilon| Self { kernel: Kernel::Gaussian, epsilon };
        plain.chain(EPSILONS.map(of)).collect()
    }
}

/// Features of the first two rows of a rotation. An orthographic view of a rigid object depends on these alone.
const TWO_ROWS: usize = 6;

/// Indices of the factors of a product of features, ascending. The empty product is 1.
pub(super) type Monomial = Vec<usize>;

/// Monomials with a name. They include the features themselves.
#[derive(Clone, Debug)]
pub(super) struct TermSet {
    pub(super) name: &'static str,
    pub(super) monomials: Vec<Monomial>,
    /// Whether the monomials include every feature that distances depend on.
    pub(super) is_whole: bool,
}

/// Lists the sets for inputs. `kept` are the indices of the features that vary.
pub(super) fn term_sets(inputs: &[Input], kept: &[usize]) -> Vec<TermSet> {
    let (mut blocks, mut rows) = (Vec::new(), Vec::new());
    for (input, first) in with_features(inputs) {
        let len = input.kind.feature_len();
        let own = |most: usize| -> Vec<usize> {
            (first..first + most.min(len)).filter(|feature| kept.contains(feature)).collect()
        };
        let is_rotation = matches!(input.kind, InputKind::Rotation { .. });
        rows.push(own(if is_rotation { TWO_ROWS } else { len }));
        blocks.push(own(len));
    }
    let has_rotation = rows != blocks;
    let set = |name, monomials: Vec<Monomial>| {
        let is_whole = kept.iter().all(|&feature| monomials.contains(&vec![feature]));
        TermSet { name, monomials, is_whole }
    };
    let mut out = vec![set("linear", linear(&blocks))];
    let rows = if has_rotation { [linear(&rows), products(&rows)] } else { Default::default() };
    let [plain, by_others] = rows;
    let others = [
        ("two rows", plain),
        ("two rows x others", by_others),
        ("products", products(&blocks)),
        ("quadratic", quadratic(&blocks)),
    ];
    for (name, monomials) in others {
        let is_new = out.iter().all(|other: &TermSet| other.monomials != monomials);
        if is_new && !monomials.is_empty() {
            out.push(set(name, monomials));
        }
    }
    out
}

/// Makes the terms of monomials, whose factors must be monomials of the list, too. Returns the sorted monomials and
/// their terms.
pub(super) fn terms(monomials: &[Monomial]) -> (Vec<Monomial>, Vec<Term>) {
    let mut sorted = monomials.to_vec();
    sorted.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    sorted.dedup();
    let place = |of: &[usize]| sorted.iter().position(|other| other == of).unwrap_or(0);
    let term = |monomial: &Monomial| match monomial.split_last() {
        None => Term::One,
        Some((&input, earlier)) => Term::Product { earlier: place(earlier), input },
    };
    let terms = sorted.iter().map(term).collect();
    (sorted, terms)
}

fn linear(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let features = blocks.iter().flatten().map(|&feature| vec![feature]);
    std::iter::once(Vec::new()).chain(features).collect()
}

/// Adds the products of features of two inputs.
fn products(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let mut out = linear(blocks);
    for (number, block) in blocks.iter().enumerate() {
        for &other in blocks[number + 1..].iter().flatten() {
            out.extend(block.iter().map(|&feature| vec![feature, other]));
        }
    }
    out
}

/// Adds the products of all pairs of features.
fn quadratic(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let all: Vec<usize> = blocks.concat();
    let pairs = |at: usize| all[at..].iter().map(move |&other| (at, other));
    let pairs = (0..all.len()).flat_map(pairs).map(|(at, other)| vec![all[at], other]);
    linear(blocks).into_iter().chain(pairs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::rotations::Feature;
    use crate::scattered::sum::{monomials, powers};

    #[test]
    fn products_that_no_view_shows_are_left_out() {
        // A smile and an open jaw, but never both: the product x y depends on 1, x and y.
        let points = Mat::from_fn(3, 2, |i, c| [[-0.4, -0.3], [0.6, -0.3], [-0.4, 0.7]][i][c]);
        let found = determined(&points, &monomials(2, 2));
        assert_eq!((found.rank(), found.terms.len()), (3, 6));
        assert!((0..6).all(|t| (found.basis.row(t).norm_max() > 0.0) == (t < 3)));
    }

    #[test]
    fn sets_are_products_of_varying_features() {
        let input = |kind| Input { name: String::new(), kind, weight: 1.0 };
        let turn = InputKind::Rotation { feature: Feature::Matrix, order: None };
        let inputs = [turn, InputKind::Scalar, InputKind::Scalar].map(input);
        let kept: Vec<usize> = (0..11).filter(|feature| *feature != 4).collect();
        let sets = term_sets(&inputs, &kept);
        let sizes: Vec<_> = sets.iter().map(|set| (set.monomials.len(), set.is_whole)).collect();
        let expected = [
            (1 + 10, true),
            (1 + 7, false),
            (1 + 7 + 5 * 2 + 1, false),
            (1 + 10 + 8 * 2 + 1, true),
            (1 + 10 + 55, true),
        ];
        assert_eq!(sizes, expected);
        assert_eq!(term_sets(&inputs[1..], &[0, 1]).len(), 3, "no rotation, no rows");
        assert_eq!(term_sets(&inputs[1..2], &[0]).len(), 2, "no products");
    }

    #[test]
    fn terms_are_their_monomials() {
        let (sorted, terms) = terms(&[vec![0, 2], vec![2], vec![], vec![0], vec![2]]);
        assert_eq!(sorted, [vec![], vec![0], vec![2], vec![0, 2]]);
        assert_eq!(powers(&terms, &[3.0, 5.0, 7.0]), [1.0, 3.0, 7.0, 21.0]);
    }
}
