//! Fit of maps to given weights, and the alternation between weights and maps.

use super::items::{Items, Supports, Weights};
use super::weights::fit_weights;
use crate::numeric::columns;
use faer::prelude::*;
use faer::{Mat, MatMut, Side};
use rayon::prelude::*;

/// Pull of a map to its last value, as a share of the mean diagonal.
const PROXIMAL: f64 = 1e-7;
/// Number of partial sums of a fit. A fixed number keeps the order of additions for any number of threads.
const CHUNKS: usize = 4;

/// Problem whose weights and maps are fitted in turn.
pub trait InTurn {
    /// Fits weights to maps. Returns the weights and their squared error.
    fn weights(&self, maps: &Mat<f64>, supports: Supports<'_>) -> (Weights, f64);
    /// Fits maps to weights, starting from the maps `from`.
    fn maps(&self, weights: &Weights, from: &Mat<f64>) -> Mat<f64>;
}

impl InTurn for Items<'_> {
    fn weights(&self, maps: &Mat<f64>, supports: Supports<'_>) -> (Weights, f64) {
        let (weights, errors) = fit_weights(self, maps, supports);
        (weights, self.sum(&errors))
    }

    fn maps(&self, weights: &Weights, from: &Mat<f64>) -> Mat<f64> {
        fit_maps(self, weights, from, PROXIMAL)
    }
}

/// Fitted weights and maps.
pub struct Blend {
    /// Weights of the items.
    pub weights: Weights,
    /// Fitted maps.
    pub maps: Mat<f64>,
    /// Squared error, summed over the items and weighted by importance.
    pub error: f64,
}

/// Schedule of the alternation between weights and maps.
#[derive(Clone, Copy)]
pub struct Alternation {
    /// Number of first rounds. In some of these rounds each item also chooses its maps.
    pub choices: usize,
    /// Items choose in every `every`-th of the first rounds. Between two choices the maps converge.
    pub every: usize,
    /// Number of last rounds, in which items keep their maps.
    pub rounds: usize,
    /// Largest momentum, as a share of the last step.
    pub momentum: f64,
}

impl Alternation {
    /// Returns the number of rounds.
    pub fn count(&self) -> usize {
        self.choices + self.rounds
    }

    /// Fits weights and maps in turn.
    ///
    /// - `others`, `maps`: starting weights and maps. An item chooses among the maps with the least error and the maps
    ///   of its starting weights.
    /// - `most`: largest number of maps that an item follows.
    /// - `advance`: called once a round.
    pub fn run(
        &self,
        fit: &impl InTurn,
        (others, maps): (&Weights, Mat<f64>),
        most: usize,
        advance: impl Fn(),
    ) -> (Weights, Mat<f64>) {
        let mut state = Round::first(others.clone(), maps);
        for round in 0..self.count() {
            let last = &state.weights;
            let supports = if round < self.choices && round.is_multiple_of(self.every) {
                Supports::Better { most, others, last }
            } else {
                Supports::Fixed(last)
            };
            state = state.next(fit, supports, self.momentum);
            advance();
        }
        (state.weights, state.maps)
    }

    /// Fits items with at most `most` maps each, from starting maps only.
    pub fn blend(
        &self,
        items: &Items<'_>,
        maps: Mat<f64>,
        most: usize,
        advance: impl Fn(),
    ) -> Blend {
        let (nearest, _) = items.weights(&maps, Supports::Free(most));
        let (weights, maps) = self.run(items, (&nearest, maps), most, advance);
        let (weights, error) = items.weights(&maps, Supports::Fixed(&weights));
        Blend { weights, maps, error }
    }
}

/// Fits maps to given weights.
///
/// - `previous`: target of the proximal term.
/// - `pull`: weight of the proximal term, as a share of the mean diagonal. The term decides directions that the items
///   leave open: a map without items, or the normal of a flat patch. It also keeps the system positive definite.
pub fn fit_maps(items: &Items<'_>, weights: &Weights, previous: &Mat<f64>, pull: f64) -> Mat<f64> {
    Normal::new(items, weights, previous, pull).solve(previous)
}

/// Normal equations of maps, `maps gram = right`.
pub struct Normal {
    /// Σ φ φᵀ over the rows of the items, with the proximal term, l·m x l·m.
    pub gram: Mat<f64>,
    /// Σ y φᵀ, with the proximal term, r x l·m.
    pub right: Mat<f64>,
}

impl Normal {
    /// Sums the equations of [`fit_maps`].
    pub fn new(items: &Items<'_>, weights: &Weights, previous: &Mat<f64>, pull: f64) -> Self {
        let (size, rank) = (previous.ncols(), items.y.nrows());
        let chunk = items.len().div_ceil(CHUNKS).max(1);
        let parts: Vec<(Mat<f64>, Mat<f64>)> = (0..items.len().div_ceil(chunk))
            .into_par_iter()
            .map_init(columns::narrow_registers, |(), c| {
                let mut normal = Mat::zeros(size, size);
                let mut right = Mat::zeros(rank, size);
                for item in c * chunk..((c + 1) * chunk).min(items.len()) {
                    for row in item * items.rows..(item + 1) * items.rows {
                        accumulate(
                            items,
                            row,
                            weights.of(item),
                            item,
                            normal.as_mut(),
                            right.as_mut(),
                        );
                    }
                }
                (normal, right)
            })
            .collect();
        let mut normal = Mat::<f64>::zeros(size, size);
        let mut right = Mat::<f64>::zeros(rank, size);
        for (n, r) in &parts {
            normal += n;
            right += r;
        }
        let mean = (0..size).map(|i| normal[(i, i)]).sum::<f64>() / size.max(1) as f64;
        let proximal = pull * mean + f64::MIN_POSITIVE;
        for i in 0..size {
            normal[(i, i)] += proximal;
        }
        right += faer::Scale(proximal) * previous;
        Self { gram: normal, right }
    }

    /// Solves the equations. Only rounding can make them indefinite; the maps are then `previous`.
    pub fn solve(&self, previous: &Mat<f64>) -> Mat<f64> {
        match self.gram.llt(Side::Lower) {
            Ok(factor) => factor.solve(self.right.transpose()).transpose().to_owned(),
            Err(_) => previous.clone(),
        }
    }
}

fn accumulate(
    items: &Items<'_>,
    row: usize,
    weights: impl Iterator<Item = (usize, f64)> + Clone,
    item: usize,
    mut normal: MatMut<'_, f64>,
    mut right: MatMut<'_, f64>,
) {
    let m = items.width;
    let h = items.row(row);
    let y = items.target(row);
    let importance = items.importance.of(item);
    for (a, wa) in weights.clone() {
        for (j, hj) in h.iter().enumerate() {
            let phi = importance * wa * hj;
            for (b, wb) in weights.clone() {
                for (i, hi) in h.iter().enumerate() {
                    normal[(b * m + i, a * m + j)] += phi * wb * hi;
                }
            }
            let mut column = right.as_mut().col_mut(a * m + j);
            for (k, value) in y.iter().enumerate() {
                column[k] += phi * value;
            }
        }
    }
}

/// State after a round.
#[derive(Clone)]
struct Round {
    weights: Weights,
    /// Squared error before the maps were fitted.
    error: f64,
    /// Fitted maps.
    maps: Mat<f64>,
    /// Start of the next round.
    start: Mat<f64>,
    /// Number of rounds since the last restart.
    steps: f64,
}

impl Round {
    fn first(weights: Weights, maps: Mat<f64>) -> Self {
        Self { weights, error: f64::INFINITY, start: maps.clone(), maps, steps: 0.0 }
    }

    /// Fits weights, then maps, with momentum (Nesterov 1983). If the error has risen, the next round restarts from the
    /// last maps without momentum.
    fn next(&self, fit: &impl InTurn, supports: Supports<'_>, momentum: f64) -> Self {
        let (weights, error) = fit.weights(&self.start, supports);
        if self.steps > 0.0 && error > self.error {
            return Self { start: self.maps.clone(), steps: 0.0, ..self.clone() };
        }
        let maps = fit.maps(&weights, &self.start);
        let step = momentum * self.steps / (self.steps + 3.0);
        let start = &maps + (&maps - &self.maps) * faer::Scale(step);
        Self { weights, error, maps, start, steps: self.steps + 1.0 }
    }
}
