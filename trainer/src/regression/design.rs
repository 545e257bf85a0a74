//! Design of a kernel fit: the part that depends on the inputs alone, so that one design serves any outputs (METHOD
//! §2.2).
//!
//! `f(x) = Σ_k c_k (G(|x - t_k|²/w) - G(|t_k|²/w)) + A x`. The columns are the orthonormal functions of the centres,
//! zero at the origin, and the scaled inputs. A ridge penalises the coefficients of the columns. If every sample is a
//! centre, this is kernel ridge regression with [`Inputs::kernel_matrix`]. The linear part is penalised too, because an
//! unpenalised linear part of many inputs overfits.

use super::confidence::MapConfidence;
use super::function::{Exact, by_name};
use super::inputs::{GreedyCentres, Inputs};
use super::map::KernelMap;
use super::outputs::{Block, LeftOut};
use crate::numeric::columns;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, Par, Side};
use serde::Serialize;
use sinew_runtime::envelope::GroupKernel;

/// Share of the variance over the samples that the variance roots may leave unexplained.
const UNEXPLAINED: f64 = 1e-6;

/// Squared distance from rest where a map's confidence starts to fade, over the squared distance of the farthest
/// sample.
const REACH: f64 = 2.0;

/// Share of the largest squared singular value below which a squared singular value is rounding.
const ROUNDED: f64 = 1e-14;

/// Parameters of a design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hyperparameters {
    /// Kernel G.
    #[serde(serialize_with = "by_name")]
    pub kernel: GroupKernel,
    /// Squared width over the median squared distance.
    pub width: f64,
    /// Number of centres besides the origin.
    pub centres: usize,
}

/// Design matrix X with a row for each of the n samples, and its decomposition.
pub struct Design<'a> {
    /// Parameters of the design.
    pub hyperparameters: Hyperparameters,
    inputs: &'a Inputs,
    centres: GreedyCentres,
    /// X.
    columns: Mat<f64>,
    /// Left singular vectors of X, n x k; their squared singular values follow, descending.
    pub(super) directions: Mat<f64>,
    squared: Vec<f64>,
    /// Largest squared singular value. Ridges are relative to it.
    largest: f64,
}

/// Block of samples that a fit leaves out.
pub struct BlockOut {
    /// Rows of the hat matrix for these samples, on the design's directions: len x k.
    hat: Mat<f64>,
    left_out: LeftOut,
    /// Variance of the noise that the ridge assumes.
    noise: f64,
}

impl<'a> Design<'a> {
    /// Makes a design; `None` if the decomposition does not converge.
    pub fn new(inputs: &'a Inputs, hyperparameters: Hyperparameters) -> Option<Self> {
        let Hyperparameters { kernel, width, centres } = hyperparameters;
        Self::each(inputs, kernel, width, &[centres]).next()
    }

    /// Makes designs with ascending numbers of centres, one at a time.
    ///
    /// Each design has the first centres of one common order. Counts above the number of possible centres give one
    /// design.
    pub fn each(
        inputs: &'a Inputs,
        kernel: GroupKernel,
        width: f64,
        counts: &[usize],
    ) -> impl Iterator<Item = Self> + use<'a> {
        let most = counts.iter().copied().max().unwrap_or(0);
        let scale = 1.0 / inputs.squared_width(width);
        let squared = |i, j| scale * inputs.squared(i, j);
        let greedy = GreedyCentres::new(kernel, inputs.sample_len(), most, squared);
        let mut counts: Vec<_> =
            counts.iter().map(|&count| count.min(greedy.order.len())).collect();
        counts.dedup();
        counts.into_iter().filter_map(move |count| {
            let hyperparameters = Hyperparameters { kernel, width, centres: count };
            let centres = greedy.first(count);
            let scaled = inputs.values().transpose() * faer::Scale(inputs.linear_share().sqrt());
            let columns = faer::concat![[centres.functions(), scaled]];
            let (directions, squared) = directions(&columns)?;
            let largest = squared.first().copied().unwrap_or(0.0);
            Some(Self { hyperparameters, inputs, centres, columns, directions, squared, largest })
        })
    }

    /// Returns n.
    pub fn sample_len(&self) -> usize {
        self.inputs.sample_len()
    }

    /// Returns the residuals of a fit to all samples with a ridge, n x r, from the outputs and their projection.
    pub fn residuals(&self, outputs: &Mat<f64>, projected: &Mat<f64>, ridge: f64) -> Mat<f64> {
        let shrink = self.shrink(ridge);
        let fitted = Mat::from_fn(projected.nrows(), projected.ncols(), |k, o| {
            shrink[k] * projected[(k, o)]
        });
        outputs - &self.directions * fitted
    }

    /// Returns the share of each direction that a fit with a ridge keeps.
    fn shrink(&self, ridge: f64) -> Vec<f64> {
        self.squared.iter().map(|s| s / (s + ridge * self.largest)).collect()
    }

    /// Leaves a block of samples out of a fit with a ridge; `None` if rounding makes the remainder indefinite.
    ///
    /// - `rows`: rows of the block.
    pub fn block_out(&self, rows: &Mat<f64>, ridge: f64) -> Option<BlockOut> {
        columns::narrow_registers();
        let shrink = self.shrink(ridge);
        let hat = Mat::from_fn(rows.nrows(), rows.ncols(), |i, k| shrink[k] * rows[(i, k)]);
        let mut remainder = Mat::<f64>::identity(rows.nrows(), rows.nrows());
        let lower = BlockStructure::TriangularLower;
        let whole = BlockStructure::Rectangular;
        let (out, onto) = (remainder.as_mut(), rows.transpose());
        triangular::matmul(out, lower, Accum::Add, &hat, whole, onto, whole, -1.0, Par::Seq);
        let noise = ridge * self.largest;
        Some(BlockOut { left_out: LeftOut::new(&remainder)?, hat, noise })
    }

    /// Solves for the coefficients of the orthonormal functions, then of the scaled inputs.
    ///
    /// The first outputs of the projection are solved for, each with its own ridge.
    pub fn solve(&self, projected: &Mat<f64>, ridges: &[f64]) -> Mat<f64> {
        let dual = self.dual(&projected.subcols(0, ridges.len()).to_owned(), |o| ridges[o]);
        self.columns.transpose() * (&self.directions * dual)
    }

    /// Solves for the coefficients of the directions, k x r.
    ///
    /// - `ridge`: ridge of each output.
    pub fn dual(&self, projected: &Mat<f64>, ridge: impl Fn(usize) -> f64) -> Mat<f64> {
        Mat::from_fn(projected.nrows(), projected.ncols(), |k, o| {
            projected[(k, o)] / (self.squared[k] + ridge(o) * self.largest)
        })
    }

    /// Returns the squared norms of the functions with given coefficients of the directions, r.
    pub fn squared_norms(&self, dual: &Mat<f64>) -> Vec<f64> {
        let norm = |o| self.squared.iter().enumerate().map(|(k, s)| s * dual[(k, o)].powi(2)).sum();
        (0..dual.ncols()).map(norm).collect()
    }

    /// Converts coefficients of the design's columns into coefficients of the kernels at the origin and at the centres,
    /// centres + 1 x r.
    fn at_centres(&self, solution: &Mat<f64>) -> Mat<f64> {
        self.centres.at_centres(&solution.subrows(0, self.hyperparameters.centres).to_owned())
    }

    /// Returns the coefficients of each direction for the kernels at the origin and at the centres, centres + 1 x k.
    pub fn directions_at_centres(&self) -> Mat<f64> {
        self.at_centres(&(self.columns.transpose() * &self.directions))
    }

    /// Returns the RMS magnitude of the rounded term of each centre, the origin first.
    ///
    /// The rounded term is the kernel's value, or, for a gaussian, the change of the value from rest.
    pub fn terms(&self) -> Vec<f64> {
        let Hyperparameters { kernel, width, .. } = self.hyperparameters;
        let (n, scale) = (self.sample_len(), 1.0 / self.inputs.squared_width(width));
        let of = |(k, centre): (usize, usize)| {
            let size = |i: usize| {
                let [here, rest, own] = [(centre, i), (centre, 0), (0, i)]
                    .map(|(i, j)| scale * self.inputs.squared(i, j));
                let twice = (2.0 * here + 2.0 * rest - own).max(0.0);
                let steepest = self.centres.value(i, k).max(self.centres.value(0, k));
                steepest * steepest * own * twice
            };
            match kernel {
                GroupKernel::Gaussian => ((1..=n).map(size).sum::<f64>() / n as f64).sqrt(),
                _ => 1.0,
            }
        };
        let centres = self.centres.order.iter().map(|sample| sample + 1);
        std::iter::once(0).chain(centres).enumerate().map(of).collect()
    }

    /// Returns the factor that scales inputs before a map of this design evaluates them.
    pub fn scale(&self) -> f64 {
        1.0 / self.inputs.squared_width(self.hyperparameters.width).sqrt()
    }

    /// Makes the map of scaled inputs.
    ///
    /// - `solution`: coefficients of the design's columns, for the outputs and then for the variance roots.
    pub fn map(&self, solution: &Mat<f64>, confidence: MapConfidence) -> KernelMap {
        let Hyperparameters { kernel, width, centres: count } = self.hyperparameters;
        let width = self.inputs.squared_width(width);
        let centres = self.at_centres(solution);
        let linear = solution.subrows(count, self.inputs.input_len())
            * faer::Scale((self.inputs.linear_share() * width).sqrt());
        let values = self.inputs.values();
        KernelMap {
            kernel,
            centres: Mat::from_fn(self.inputs.input_len(), count + 1, |r, k| {
                if k == 0 { 0.0 } else { values[(r, self.centres.order[k - 1])] / width.sqrt() }
            }),
            coefficients: faer::concat![[centres.transpose(), linear.transpose()]],
            confidence,
        }
    }

    /// Returns the coefficients of the variance roots, k x m: values whose squares sum to the variance that a fit with
    /// a ridge explains.
    ///
    /// At most `most` leading directions have a root. The roots are scaled up, so that their sum over the samples is
    /// the variance that all directions explain.
    pub fn variance_roots(&self, ridge: f64, most: usize) -> Mat<f64> {
        let s = &self.squared;
        let share = |i: usize| s[i] / (s[i] + ridge * self.largest);
        let explained = |count: usize| (0..count).map(|i| s[i] * share(i)).sum::<f64>();
        let len = self.root_len(most);
        let others = explained(s.len()) / explained(len).max(f64::MIN_POSITIVE);
        let v = self.columns.transpose() * self.directions.subcols(0, len);
        Mat::from_fn(v.nrows(), len, |row, i| v[(row, i)] * (others * share(i) / s[i]).sqrt())
    }

    /// Counts the roots of [`Design::variance_roots`], m.
    pub fn root_len(&self, most: usize) -> usize {
        let mut left: f64 = self.squared.iter().sum();
        let negligible = UNEXPLAINED * left;
        let needed = self.squared.iter().take_while(|s| {
            let needed = left > negligible;
            left -= *s;
            needed
        });
        needed.count().min(most)
    }

    /// Returns the confidence of a map without variance roots, with the design's distances.
    pub fn confidence(&self) -> MapConfidence {
        let width = self.inputs.squared_width(self.hyperparameters.width);
        let farthest =
            (1..=self.sample_len()).map(|i| self.inputs.squared(0, i)).fold(0.0, f64::max);
        MapConfidence {
            reach: REACH * farthest / width,
            linear: self.inputs.linear_share() * width,
            ..MapConfidence::default()
        }
    }

    /// Returns the prior variance, summed over the samples.
    pub fn variance(&self) -> f64 {
        (0..self.sample_len()).map(|i| self.prior(i)).sum()
    }

    /// Returns the prior variance times the growth of an error, summed over the samples.
    pub fn grown_variance(&self) -> f64 {
        let growth = self.growth();
        (0..self.sample_len()).map(|i| growth(i) * self.prior(i)).sum()
    }

    /// Returns a function that computes the growth of an error at a sample.
    fn growth(&self) -> impl Fn(usize) -> f64 {
        let confidence = self.confidence();
        let width = self.inputs.squared_width(self.hyperparameters.width);
        move |sample| confidence.growth(self.inputs.squared(0, sample + 1) / width)
    }

    /// Returns the prior variance of a sample.
    fn prior(&self, sample: usize) -> f64 {
        let Hyperparameters { kernel, width, .. } = self.hyperparameters;
        let apart = self.inputs.squared(0, sample + 1);
        let rest = kernel.exact(apart / self.inputs.squared_width(width));
        1.0 - rest.powi(2) + self.inputs.linear_share() * apart
    }

    /// Returns the part of a sample's prior variance outside the span of the centres.
    fn unspanned(&self, sample: usize) -> f64 {
        let spanned = self.columns.row(sample).squared_norm_l2();
        (self.prior(sample) - spanned).max(0.0)
    }
}

/// Decomposes a matrix into left singular vectors, n x k, and squared singular values, descending; `None` if the
/// decomposition does not converge.
///
/// The decomposition uses inner products, in half the time of a decomposition of the matrix. Directions that this
/// rounds away are far below every ridge.
fn directions(columns: &Mat<f64>) -> Option<(Mat<f64>, Vec<f64>)> {
    let is_wide = columns.nrows() <= columns.ncols();
    let products =
        if is_wide { columns * columns.transpose() } else { columns.transpose() * columns };
    let eigen = products.self_adjoint_eigen(Side::Lower).ok()?;
    let mut squared: Vec<f64> = eigen.S().column_vector().iter().rev().copied().collect();
    let least = ROUNDED * squared.first()?;
    squared.truncate(squared.iter().take_while(|&&s| s > least).count());
    let vectors = eigen.U().reverse_cols().subcols(0, squared.len());
    if is_wide {
        return Some((vectors.to_owned(), squared));
    }
    let mut directions = columns * vectors;
    for (mut direction, s) in directions.col_iter_mut().zip(&squared) {
        direction *= faer::Scale(1.0 / s.sqrt());
    }
    Some((directions, squared))
}

impl BlockOut {
    /// Returns the residuals of the samples that are left out, in a fit to all samples, a row each.
    ///
    /// - `outputs`: outputs of these samples.
    /// - `projected`: projection of all outputs.
    pub fn residuals(&self, outputs: &Mat<f64>, projected: &Mat<f64>) -> Mat<f64> {
        outputs - &self.hat * projected
    }

    /// Converts residuals into the errors of the block's predicted samples.
    pub fn errors(&self, block: &Block, residuals: &Mat<f64>) -> Mat<f64> {
        self.left_out.errors(residuals).subrows(0, block.own.len()).to_owned()
    }

    /// Returns the variance of the fit without the block times the growth of an error, summed over the block's predicted
    /// samples.
    pub fn grown_variance(&self, design: &Design<'_>, block: &Block) -> f64 {
        let growth = design.growth();
        let of =
            |(&i, v): (&usize, &f64)| growth(i) * (design.unspanned(i) + self.noise * (v - 1.0));
        block.own.iter().zip(&self.left_out.variances()).map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::linalg::solvers::Solve;

    fn inputs() -> Inputs {
        let at = |r: usize, i: usize| [(0.37 * i as f64).sin(), (0.61 * i as f64).cos()][r];
        Inputs::new(Mat::from_fn(2, 20, at)).unwrap()
    }

    fn design(inputs: &Inputs, centres: usize) -> Design<'_> {
        let hyperparameters =
            Hyperparameters { kernel: GroupKernel::Gaussian, width: 4.0, centres };
        Design::new(inputs, hyperparameters).unwrap()
    }

    #[test]
    fn blocks_left_out_in_closed_form_equal_fits_without_them() {
        let inputs = inputs();
        for design in [6, 20].map(|centres| design(&inputs, centres)) {
            let x = design.columns.clone();
            let all = Mat::from_fn(20, 2, |i, o| (0.3 * i as f64 + o as f64).sin());
            let ridge = 1e-3 * design.largest;
            let scattered = Block { own: vec![3, 11, 12, 17], near: vec![2, 4, 19] };
            for block in [Block::row(0..7), Block::row(7..12), Block::row(12..20), scattered] {
                let out: Vec<usize> = block.out().collect();
                let own = Mat::from_fn(out.len(), 2, |i, o| all[(out[i], o)]);
                let left = design.block_out(&block.rows(&design.directions), 1e-3).unwrap();
                let projected = design.directions.transpose() * &all;
                let residuals = left.residuals(&own, &projected);
                let same = block.rows(&design.residuals(&all, &projected, 1e-3));
                assert!((&same - &residuals).norm_max() < 1e-12);
                let found = left.errors(&block, &residuals);
                let kept: Vec<usize> = (0..20).filter(|i| !out.contains(i)).collect();
                let a = Mat::from_fn(kept.len(), x.ncols(), |r, c| x[(kept[r], c)]);
                let y = Mat::from_fn(kept.len(), 2, |r, c| all[(kept[r], c)]);
                let mut normal = a.transpose() * &a;
                (0..normal.nrows()).for_each(|i| normal[(i, i)] += ridge);
                let solution = normal.llt(Side::Lower).unwrap().solve(a.transpose() * y);
                let predicted = &x * solution;
                assert_eq!(found.nrows(), block.own.len());
                for (place, &i) in block.own.iter().enumerate() {
                    for o in 0..2 {
                        let expected = all[(i, o)] - predicted[(i, o)];
                        let found = found[(place, o)];
                        assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()));
                    }
                }
            }
        }
    }

    /// Variance of a fit to some samples at another sample, in closed form.
    fn variance(x: &Mat<f64>, kept: &[usize], at: usize, ridge: f64) -> f64 {
        let a = Mat::from_fn(kept.len(), x.ncols(), |r, c| x[(kept[r], c)]);
        let mut normal = a.transpose() * &a;
        (0..normal.nrows()).for_each(|i| normal[(i, i)] += ridge);
        let own = Mat::from_fn(x.ncols(), 1, |c, _| x[(at, c)]);
        ridge * (own.transpose() * normal.llt(Side::Lower).unwrap().solve(&own))[(0, 0)]
    }

    #[test]
    fn variances_include_the_fit_without_a_block_and_the_unspanned_prior() {
        let inputs = inputs();
        for design in [6, 20].map(|centres| design(&inputs, centres)) {
            let (x, ridge) = (design.columns.clone(), 1e-3 * design.largest);
            let block = Block { own: vec![3, 11, 12], near: vec![2, 4] };
            let kept: Vec<usize> = (0..20).filter(|i| !block.out().any(|out| out == *i)).collect();
            let growth = design.growth();
            let of = |&i: &usize| {
                let prior: f64 = design.prior(i) - x.row(i).squared_norm_l2();
                growth(i) * (variance(&x, &kept, i, ridge) + prior)
            };
            let expected: f64 = block.own.iter().map(of).sum();
            let out = design.block_out(&block.rows(&design.directions), 1e-3).unwrap();
            let found = out.grown_variance(&design, &block);
            assert!((found - expected).abs() < 1e-9 && expected > 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn variance_roots_give_the_variance_that_all_samples_explain() {
        let inputs = inputs();
        for design in [6, 20].map(|centres| design(&inputs, centres)) {
            let (x, ridge) = (design.columns.clone(), 1e-3 * design.largest);
            let rows = design.variance_roots(1e-3, 16);
            assert_eq!(rows.ncols(), design.root_len(16));
            let all = Vec::from_iter(0..20);
            for i in 0..20 {
                let explained = (x.row(i) * &rows).squared_norm_l2();
                let left = x.row(i).squared_norm_l2() - explained;
                let expected = variance(&x, &all, i, ridge);
                assert!((left - expected).abs() < 1e-4, "{left} {expected}");
            }
            let fitted =
                design.map(&rows, MapConfidence { len: rows.ncols(), ..design.confidence() });
            let input: Vec<f64> =
                inputs.values().col(7).iter().map(|x| design.scale() * x).collect();
            let expected = fitted.evaluate(&input).expected_error;
            assert_eq!(expected.explained, 0.0, "no signal");
            let trusted =
                MapConfidence { len: rows.ncols(), signal: 1.0, noise: 1.0, ..design.confidence() };
            let expected = design.map(&rows, trusted).evaluate(&input).expected_error;
            let growth = design.growth()(7);
            let sum = expected.explained + expected.unexplained;
            assert!((sum - growth * design.prior(7)).abs() < 1e-9);
            let explained = (x.row(7) * &rows).squared_norm_l2();
            assert!((expected.explained - growth * explained).abs() < 1e-9);
        }
    }

    #[test]
    fn with_every_sample_a_centre_columns_make_the_kernel_matrix() {
        let inputs = inputs();
        let x = design(&inputs, 20).columns;
        let expected = inputs.kernel_matrix(GroupKernel::Gaussian, 4.0);
        assert!((&x * x.transpose() - expected).norm_max() < 1e-12);
    }

    #[test]
    fn larger_numbers_of_centres_begin_with_the_smaller() {
        let inputs = inputs();
        let designs: Vec<_> =
            Design::each(&inputs, GroupKernel::Matern32, 4.0, &[3, 8, 30, 40]).collect();
        let counts: Vec<_> = designs.iter().map(|d| d.hyperparameters.centres).collect();
        assert_eq!(counts, [3, 8, 20]);
        assert_eq!(designs[0].centres.order, designs[2].centres.order[..3]);
    }
}
