//! The fit of weights to given maps.

use super::items::{Items, Maps, Pull, Pulled, Supports, Weights};
use crate::numeric::columns;
use crate::numeric::columns::dot_by_lanes;
use crate::numeric::simplex::{self, Gram, MAX_COLUMNS};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;

/// Most maps that a fit of one item looks at: those of the least cost by themselves.
pub const CANDIDATES: usize = 12;
/// Error of a Gram matrix's entries, relative to the squared length of the target.
const ROUNDING: f64 = 1e-14;
/// Least weight where weights are pulled: less is a trace of the pull, which nobody sees.
const LEAST: f64 = 1e-3;
/// Items that are read at a time.
const BLOCK: usize = 256;

/// Fits the weights of every item to given maps; returns them and the items' squared errors.
pub fn fit_weights(items: &Items<'_>, maps: &Maps, supports: Supports<'_>) -> (Weights, Vec<f64>) {
    let products = Products::new(maps);
    let of_block = |block: usize| {
        let range = block * BLOCK..((block + 1) * BLOCK).min(items.len());
        let onto = products.onto(items, range.clone(), supports);
        let of_items = onto.chunks_exact(items.rows * maps.columns.ncols());
        let fit = |(item, onto)| ItemFit::new(items, item, &products, onto).run(supports);
        range.zip(of_items).map(fit).collect()
    };
    let blocks: Vec<Vec<ItemWeights>> =
        (0..items.len().div_ceil(BLOCK)).into_par_iter().map(of_block).collect();
    let errors = blocks.iter().flatten().map(|item| item.1).collect();
    (Weights::from_lists(supports.most(), blocks.into_iter().flatten().map(|item| item.0)), errors)
}

/// Inner products of l maps' columns.
struct Products {
    /// Those of the columns of each two maps together, m² of a pair: l x l x m x m.
    pairs: Vec<f64>,
    /// Those of each map's own columns, l x m².
    own: Mat<f64>,
    /// The maps' columns, the first ones of all maps first: r x m·l.
    by_entry: Mat<f64>,
}

impl Products {
    fn new(Maps { width: m, columns }: &Maps) -> Self {
        let (size, len, square) = (columns.ncols(), columns.ncols() / m, m * m);
        let mut pairs = vec![0.0; size * size];
        pairs.par_chunks_mut(size * m).enumerate().for_each(|(map, out)| {
            let products = columns.transpose() * columns.subcols(m * map, *m);
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

    /// Computes the inner products of [`Products::by_entry`] and the targets of some items, row by row, those that their
    /// supports ask for.
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

/// An item's maps and weights, strongest first, and its squared error.
type ItemWeights = (Vec<(usize, f64)>, f64);

fn by_error(a: &(f64, usize), b: &(f64, usize)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// The fit of an item's weights.
struct ItemFit<'a> {
    /// m.
    width: usize,
    /// Rows h of the item, and Σ h hᵀ.
    h: &'a [f64],
    squares: Vec<f64>,
    /// Squared length of its target.
    size: f64,
    item: usize,
    /// The weights that its own are pulled to, and the constant part of their cost.
    pull: Option<(Pull<'a>, f64)>,
    products: &'a Products,
    /// Its part of [`Products::onto`].
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

    /// Lists the maps that have the least cost by themselves, each with its error.
    fn nearest(&self) -> Vec<(f64, usize)> {
        let errors = self.errors_alone();
        let cost = |map: usize| {
            let pulled = self.pulled(map);
            errors[map] + pulled.product(&pulled)
        };
        let mut costs: Vec<_> = (0..errors.len()).map(|map| (cost(map), map)).collect();
        if costs.len() > CANDIDATES {
            costs.select_nth_unstable_by(CANDIDATES, by_error);
            costs.truncate(CANDIDATES);
        }
        costs.into_iter().map(|(_, map)| (errors[map], map)).collect()
    }

    /// Fits at most `most` weights of candidates, each with its error alone.
    fn solve(&self, mut candidates: Vec<(f64, usize)>, most: usize) -> ItemWeights {
        candidates.sort_by(by_error);
        let gram = self.gram(&candidates);
        let mut pulled = [Pulled::default(); MAX_COLUMNS];
        pulled.iter_mut().zip(&candidates).for_each(|(own, of)| *own = self.pulled(of.1));
        let constant = self.pull.map_or(0.0, |pull| pull.1);
        let cost = gram.plus(|i, j| constant + pulled[i].product(&pulled[j]));
        let least = if self.pull.is_some() { LEAST } else { 0.0 };
        let weights = simplex::solve_sparse(&cost, most, least);
        let mut list: Vec<(usize, f64)> = (0..gram.len)
            .filter(|&i| weights[i] > 0.0)
            .map(|i| (candidates[i].1, weights[i]))
            .collect();
        list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        (list, gram.error(&weights))
    }

    /// Returns the error of weights with the cost of the pull.
    fn cost(&self, (list, error): &ItemWeights) -> f64 {
        let of_map = |&(a, w): &(usize, f64)| {
            list.iter().map(|&(b, v)| w * v * self.pulled(a).product(&self.pulled(b))).sum::<f64>()
        };
        error + list.iter().map(of_map).sum::<f64>()
    }

    /// Returns a map in the cost of the pull.
    fn pulled(&self, map: usize) -> Pulled {
        self.pull.map_or(Pulled::default(), |(pull, _)| pull.of(self.item, map))
    }

    /// Gives the item's squared error by each map alone.
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

    /// Gives the same of one map.
    fn error_alone(&self, map: usize) -> f64 {
        self.product(map, map) - 2.0 * self.toward(map) + self.size
    }

    /// The Gram matrix of what candidates leave of the item's target, each with its error.
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

    /// The inner product of what two maps make of the item.
    fn product(&self, a: usize, b: usize) -> f64 {
        let square = self.squares.len();
        let pair = a * self.products.own.nrows() + b;
        dot_by_lanes(&self.products.pairs[square * pair..][..square], &self.squares)
    }

    /// The inner product of what a map makes of the item and its target.
    fn toward(&self, map: usize) -> f64 {
        let of_row = |(h, onto): (&[f64], &[f64])| {
            let own = onto.iter().skip(map).step_by(self.products.own.nrows());
            own.zip(h).map(|(p, x)| p * x).sum::<f64>()
        };
        self.rows().map(of_row).sum()
    }

    /// Rows h, and of [`Products::onto`].
    fn rows(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let size = self.products.by_entry.ncols();
        self.h.chunks_exact(self.width).zip(self.onto.chunks_exact(size))
    }
}
