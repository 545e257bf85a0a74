//! Fit of weights to given maps.

use super::items::{Items, Pull, PullTerm, Supports, Weights};
use crate::numeric::columns;
use crate::numeric::columns::dot_by_lanes;
use crate::numeric::simplex::{self, Gram, MAX_COLUMNS};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;

/// Largest number of candidate maps of an item: the maps with the least cost alone.
pub const CANDIDATES: usize = 12;
/// Rounding error of the entries of a Gram matrix, relative to the squared length of the target.
const ROUNDING: f64 = 1e-14;
/// Smallest weight under a pull. Smaller weights are invisible traces of the pull.
const LEAST: f64 = 1e-3;
/// Items of a block, which share one matrix product.
const BLOCK: usize = 256;

/// Fits the weights of every item to given maps, r x (l·m). Returns the weights and the squared error of each item.
pub fn fit_weights(
    items: &Items<'_>,
    maps: &Mat<f64>,
    supports: Supports<'_>,
) -> (Weights, Vec<f64>) {
    let products = Products::new(items.width, maps);
    let of_block = |block: usize| {
        let range = block * BLOCK..((block + 1) * BLOCK).min(items.len());
        let onto = products.onto(items, range.clone(), supports);
        let of_items = onto.chunks_exact(items.rows * maps.ncols());
        let fit = |(item, onto)| ItemFit::new(items, item, &products, onto).run(supports);
        range.zip(of_items).map(fit).collect()
    };
    let blocks: Vec<Vec<ItemWeights>> =
        (0..items.len().div_ceil(BLOCK)).into_par_iter().map(of_block).collect();
    let errors = blocks.iter().flatten().map(|item| item.1).collect();
    (Weights::from_lists(supports.most(), blocks.into_iter().flatten().map(|item| item.0)), errors)
}

/// Inner products of the columns of l maps.
struct Products {
    /// Products between the columns of two maps, m² numbers a pair: l x l x m x m.
    pairs: Vec<f64>,
    /// Products between the columns of one map, l x m².
    own: Mat<f64>,
    /// Columns of the maps: first the first column of every map, then the second: r x m·l.
    by_entry: Mat<f64>,
}

impl Products {
    fn new(m: usize, columns: &Mat<f64>) -> Self {
        let (size, len, square) = (columns.ncols(), columns.ncols() / m, m * m);
        let mut pairs = vec![0.0; size * size];
        pairs.par_chunks_mut(size * m).enumerate().for_each(|(map, out)| {
            let products = columns.transpose() * columns.subcols(m * map, m);
            for (other, out) in out.chunks_exact_mut(square).enumerate() {
                let entry = |k: usize| products[(m * other + k % m, k / m)];
                out.iter_mut().enumerate().for_each(|(k, out)| *out = entry(k));
            }
        });
        let own = Mat::from_fn(len, square, |map, k| pairs[(map * len + map) * square + k]);
        let place = |entry: usize| m * (entry % len) + entry / len;
        let by_entry =
            Mat::from_fn(columns.nrows(), size, |row, entry| columns[(row, place(entry))]);
        Self { pairs, own, by_entry }
    }

    /// Computes the inner products of [`Products::by_entry`] with the targets of some items, row by row. Maps outside
    /// the supports may be left out.
    fn onto(&self, items: &Items<'_>, range: Range<usize>, supports: Supports<'_>) -> Vec<f64> {
        let y = items.y.subcols(range.start * items.rows, range.len() * items.rows);
        let size = self.by_entry.ncols();
        let mut onto = vec![0.0; size * y.ncols()];
        match supports {
            Supports::Free(_) | Supports::Better { .. } => {
                let out = MatMut::from_column_major_slice_mut(&mut onto, size, y.ncols());
                matmul(out, Accum::Replace, self.by_entry.transpose(), y, 1.0, Par::Seq);
                columns::narrow_registers();
            }
            Supports::Fixed(weights) => {
                for (row, out) in onto.chunks_exact_mut(size).enumerate() {
                    for (map, _) in weights.of(range.start + row / items.rows) {
                        for entry in (map..size).step_by(self.own.nrows()) {
                            out[entry] = self.by_entry.col(entry).transpose() * y.col(row);
                        }
                    }
                }
            }
        }
        onto
    }
}

/// Maps and weights of an item, strongest first, and its squared error.
type ItemWeights = (Vec<(usize, f64)>, f64);

fn by_error(a: &(f64, usize), b: &(f64, usize)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// Fit of the weights of one item.
struct ItemFit<'a> {
    /// Width m of a row.
    width: usize,
    /// Rows h of the item.
    h: &'a [f64],
    /// Σ h hᵀ over the rows, m².
    squares: Vec<f64>,
    /// Squared length of the item's target.
    size: f64,
    item: usize,
    /// Pull to prior weights, and the constant part of its cost.
    pull: Option<(Pull<'a>, f64)>,
    products: &'a Products,
    /// Part of [`Products::onto`] for the item.
    onto: &'a [f64],
}

impl<'a> ItemFit<'a> {
    fn new(items: &'a Items<'_>, item: usize, products: &'a Products, onto: &'a [f64]) -> Self {
        let rows = item * items.rows..(item + 1) * items.rows;
        let size =
            rows.clone().map(|row| items.y.col_as_slice(row)).map(|y| dot_by_lanes(y, y)).sum();
        let h = &items.h[rows.start * items.width..rows.end * items.width];
        let m = items.width;
        let mut squares = vec![0.0; m * m];
        for h in h.chunks_exact(m) {
            for (squares, hj) in squares.chunks_exact_mut(m).zip(h) {
                squares.iter_mut().zip(h).for_each(|(square, hi)| *square += hi * hj);
            }
        }
        let pull = items.pull.map(|pull| (pull, pull.constant(item)));
        Self { width: m, h, squares, size, item, pull, products, onto }
    }

    fn run(&self, supports: Supports<'_>) -> ItemWeights {
        let own = |weights: &Weights| -> Vec<(f64, usize)> {
            weights.of(self.item).map(|(map, _)| (self.error_alone(map), map)).collect()
        };
        let most = supports.most();
        match supports {
            Supports::Fixed(weights) => self.solve(own(weights), most),
            Supports::Free(_) => self.solve(self.nearest(), most),
            Supports::Better { others, last, .. } => {
                let mut candidates = self.nearest();
                for (error, map) in own(others) {
                    if candidates.len() < MAX_COLUMNS && candidates.iter().all(|c| c.1 != map) {
                        candidates.push((error, map));
                    }
                }
                let (chosen, kept) = (self.solve(candidates, most), self.solve(own(last), most));
                if self.cost(&chosen) < self.cost(&kept) { chosen } else { kept }
            }
        }
    }

    /// Lists the maps with the least cost alone, each with its error alone.
    fn nearest(&self) -> Vec<(f64, usize)> {
        let errors = self.errors_alone();
        let cost = |map: usize| {
            let term = self.pull_term(map);
            errors[map] + term.product(&term)
        };
        let mut costs: Vec<_> = (0..errors.len()).map(|map| (cost(map), map)).collect();
        if costs.len() > CANDIDATES {
            costs.select_nth_unstable_by(CANDIDATES, by_error);
            costs.truncate(CANDIDATES);
        }
        costs.into_iter().map(|(_, map)| (errors[map], map)).collect()
    }

    /// Fits at most `most` weights on candidate maps, given with their errors alone.
    fn solve(&self, mut candidates: Vec<(f64, usize)>, most: usize) -> ItemWeights {
        candidates.sort_by(by_error);
        let gram = self.gram(&candidates);
        let mut terms = [PullTerm::default(); MAX_COLUMNS];
        terms.iter_mut().zip(&candidates).for_each(|(term, of)| *term = self.pull_term(of.1));
        let constant = self.pull.map_or(0.0, |pull| pull.1);
        let cost = gram.plus(|i, j| constant + terms[i].product(&terms[j]));
        let least = if self.pull.is_some() { LEAST } else { 0.0 };
        let weights = simplex::solve_sparse(&cost, most, least);
        let mut list: Vec<(usize, f64)> = (0..gram.len)
            .filter(|&i| weights[i] > 0.0)
            .map(|i| (candidates[i].1, weights[i]))
            .collect();
        list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        (list, gram.error(&weights))
    }

    /// Returns the error of weights plus the cost of the pull.
    fn cost(&self, (list, error): &ItemWeights) -> f64 {
        let of_map = |&(a, w): &(usize, f64)| {
            list.iter()
                .map(|&(b, v)| w * v * self.pull_term(a).product(&self.pull_term(b)))
                .sum::<f64>()
        };
        error + list.iter().map(of_map).sum::<f64>()
    }

    /// Returns the terms of a map in the cost of the pull.
    fn pull_term(&self, map: usize) -> PullTerm {
        self.pull.map_or(PullTerm::default(), |(pull, _)| pull.of(self.item, map))
    }

    /// Computes the item's squared error by each map alone.
    fn errors_alone(&self) -> Vec<f64> {
        let len = self.products.own.nrows();
        let mut errors = vec![self.size; len];
        let mut add = |factor: f64, values: &[f64]| {
            errors.iter_mut().zip(values).for_each(|(error, value)| *error += factor * value);
        };
        for (h, onto) in self.rows() {
            for (h, onto) in h.iter().zip(onto.chunks_exact(len)) {
                add(-2.0 * h, onto);
            }
        }
        for (k, square) in self.squares.iter().enumerate() {
            add(*square, self.products.own.col_as_slice(k));
        }
        errors
    }

    /// Computes the item's squared error by one map alone.
    fn error_alone(&self, map: usize) -> f64 {
        self.product(map, map) - 2.0 * self.toward(map) + self.size
    }

    /// Computes the Gram matrix of the residuals of candidate maps, given with their errors alone.
    fn gram(&self, candidates: &[(f64, usize)]) -> Gram {
        let value = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        let mut gram = Gram { len: candidates.len(), noise: ROUNDING * self.size, value };
        let toward: Vec<f64> = candidates.iter().map(|c| self.toward(c.1)).collect();
        for (i, &(error, a)) in candidates.iter().enumerate() {
            gram.value[i][i] = error.max(0.0);
            for (j, &(_, b)) in candidates.iter().enumerate().take(i) {
                let value = self.product(a, b) - toward[i] - toward[j] + self.size;
                gram.value[i][j] = value;
                gram.value[j][i] = value;
            }
        }
        gram
    }

    /// Computes the inner product of the item's motions by two maps.
    fn product(&self, a: usize, b: usize) -> f64 {
        let square = self.squares.len();
        let pair = a * self.products.own.nrows() + b;
        dot_by_lanes(&self.products.pairs[square * pair..][..square], &self.squares)
    }

    /// Computes the inner product of the item's motion by a map and the item's target.
    fn toward(&self, map: usize) -> f64 {
        let of_row = |(h, onto): (&[f64], &[f64])| {
            let own = onto.iter().skip(map).step_by(self.products.own.nrows());
            own.zip(h).map(|(p, x)| p * x).sum::<f64>()
        };
        self.rows().map(of_row).sum()
    }

    /// Iterates over rows h and rows of [`Products::onto`].
    fn rows(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let size = self.products.by_entry.ncols();
        self.h.chunks_exact(self.width).zip(self.onto.chunks_exact(size))
    }
}
