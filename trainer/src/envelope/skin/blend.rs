//! Blends of maps: the least-squares problem that LBS weights, proxies and keys share.
//!
//! An item (a vertex, a triangle) has one or more rows h of width m with a target trajectory y in
//! R^r each; l maps `M_l` (r x m) are blended with weights w: `y ≈ Σ_l w_l M_l h`, w ≥ 0, Σw = 1,
//! at most K of them not zero. Weights and maps are fitted in turn (METHOD §1.2, §1.7).

use crate::examples::Importance;
use crate::numeric::simplex::{self, Gram, MAX_COLUMNS};
use crate::progress::Progress;
use faer::linalg::matmul::matmul;
use faer::prelude::*;
use faer::{Accum, Mat, MatMut, Par, Side};
use rayon::prelude::*;
use std::ops::Range;

/// Most maps that a weight fit of one item looks at, nearest in error first.
pub const CANDIDATES: usize = 12;
/// Error of a Gram matrix's entries, relative to the squared length of the target.
const ROUNDING: f64 = 1e-14;
/// Partial sums that a fit of maps is split into, so that threads do not change the order.
const CHUNKS: usize = 16;

/// Items to be blended.
pub struct Items<'a> {
    /// m.
    pub width: usize,
    /// Rows per item.
    pub rows: usize,
    /// Rows h, items x rows x m.
    pub h: Vec<f64>,
    /// Targets, r x (items·rows).
    pub y: &'a Mat<f64>,
    /// How much each item counts when maps are fitted.
    pub importance: Importance<'a>,
}

impl<'a> Items<'a> {
    /// One row `[x̂ 1]` a vertex, with their trajectories r x V.
    pub fn vertices(rest: &[[f64; 3]], y: &'a Mat<f64>, importance: Importance<'a>) -> Self {
        let h = rest.iter().flat_map(|x| [x[0], x[1], x[2], 1.0]).collect();
        Self { width: 4, rows: 1, h, y, importance }
    }

    /// Returns the number of items.
    pub fn len(&self) -> usize {
        self.y.ncols() / self.rows
    }

    /// Returns whether there is no item.
    pub fn is_empty(&self) -> bool {
        self.y.ncols() == 0
    }

    /// Sums the items' errors as they count.
    pub fn sum(&self, errors: &[f64]) -> f64 {
        errors.iter().enumerate().map(|(item, error)| self.importance.of(item) * error).sum()
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.h[row * self.width..(row + 1) * self.width]
    }
}

/// Maps side by side: r x (l·m).
pub struct Maps {
    /// m.
    pub width: usize,
    /// Columns l·m..l·m+m are map l.
    pub columns: Mat<f64>,
}

impl Maps {
    /// Returns the number of maps.
    pub fn len(&self) -> usize {
        self.columns.ncols() / self.width
    }

    /// Returns whether there is no map.
    pub fn is_empty(&self) -> bool {
        self.columns.ncols() == 0
    }
}

/// At most K weights an item.
#[derive(Clone, Debug)]
pub struct Weights {
    most: usize,
    entries: Vec<(u32, f64)>,
}

impl Weights {
    /// Returns K.
    pub fn most(&self) -> usize {
        self.most
    }

    /// Returns the number of items.
    pub fn len(&self) -> usize {
        self.entries.len() / self.most
    }

    /// Returns whether there is no item.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the maps and weights of an item that are not zero, strongest first.
    pub fn of(&self, item: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let entries = &self.entries[item * self.most..(item + 1) * self.most];
        entries.iter().take_while(|e| e.1 > 0.0).map(|&(map, weight)| (map as usize, weight))
    }

    /// Returns the map that an item follows most; none where it follows none.
    pub fn strongest(&self, item: usize) -> Option<usize> {
        self.of(item).next().map(|(map, _)| map)
    }

    /// Builds weights from lists of (map, weight), each at most `most` long, strongest first.
    pub fn from_lists(most: usize, lists: impl Iterator<Item = Vec<(usize, f64)>>) -> Self {
        let mut entries = Vec::new();
        for list in lists {
            let end = entries.len() + most;
            entries.extend(list.into_iter().map(|(map, weight)| (map as u32, weight)).take(most));
            entries.resize(end, (0, 0.0));
        }
        Self { most, entries }
    }
}

/// The maps that items may follow.
#[derive(Clone, Copy)]
pub enum Supports<'a> {
    /// At most so many of those that come nearest by themselves, and of some others.
    Free(usize, Option<&'a Weights>),
    /// Those that they follow by these weights.
    Fixed(&'a Weights),
}

impl Supports<'_> {
    fn most(&self) -> usize {
        match self {
            Self::Free(most, _) => *most,
            Self::Fixed(weights) => weights.most(),
        }
    }
}

/// Pull of an alternation's maps to where they were.
const PROXIMAL: f64 = 1e-7;

/// Weights and maps fitted in turn.
#[derive(Clone, Copy)]
pub struct Alternation {
    /// Most rounds.
    pub rounds: usize,
    /// Gain of a round, relative to the RMS error, below which it is the last.
    pub gain: f64,
}

/// What an alternation comes to.
pub struct Blend {
    /// Weights of the items.
    pub weights: Weights,
    /// The maps.
    pub maps: Maps,
    /// Squared error, summed over the items as they count.
    pub error: f64,
}

impl Alternation {
    /// Fits blends of at most `most` maps an item, starting from given maps.
    pub fn run(
        &self,
        items: &Items<'_>,
        maps: Maps,
        most: usize,
        progress: &dyn Progress,
    ) -> Blend {
        let supports = Supports::Free(most, None);
        let (weights, errors) = fit_weights(items, &maps, supports);
        let mut blend = Blend { weights, maps, error: items.sum(&errors) };
        for _ in 0..self.rounds {
            progress.advance(1);
            let maps = fit_maps(items, &blend.weights, &blend.maps, PROXIMAL);
            let (weights, errors) = fit_weights(items, &maps, supports);
            let last = blend.error;
            blend = Blend { weights, maps, error: items.sum(&errors) };
            if last.sqrt() - blend.error.sqrt() < self.gain * last.sqrt() {
                break;
            }
        }
        blend
    }
}

/// Fits the weights of every item to given maps; returns them and the items' squared errors.
pub fn fit_weights(items: &Items<'_>, maps: &Maps, supports: Supports<'_>) -> (Weights, Vec<f64>) {
    let products = {
        let mut all = Mat::<f64>::zeros(maps.columns.ncols(), maps.columns.ncols());
        matmul(
            all.as_mut(),
            Accum::Replace,
            maps.columns.transpose(),
            &maps.columns,
            1.0,
            Par::Seq,
        );
        all
    };
    let block = 256;
    let blocks: Vec<Vec<FittedItem>> = (0..items.len().div_ceil(block))
        .into_par_iter()
        .map(|b| {
            let range = b * block..((b + 1) * block).min(items.len());
            let onto = onto(items, maps, range.clone(), supports);
            range
                .clone()
                .map(|i| fit_item(items, i, &products, &onto, range.start, supports))
                .collect()
        })
        .collect();
    let errors = blocks.iter().flatten().map(|item| item.1).collect();
    (Weights::from_lists(supports.most(), blocks.into_iter().flatten().map(|item| item.0)), errors)
}

/// Computes the inner products of maps' columns and some items' targets, those that their supports ask for.
fn onto(items: &Items<'_>, maps: &Maps, range: Range<usize>, supports: Supports<'_>) -> Mat<f64> {
    let y = items.y.subcols(range.start * items.rows, range.len() * items.rows);
    let mut onto = Mat::<f64>::zeros(maps.columns.ncols(), y.ncols());
    match supports {
        Supports::Free(..) => {
            matmul(onto.as_mut(), Accum::Replace, maps.columns.transpose(), y, 1.0, Par::Seq);
        }
        Supports::Fixed(weights) => {
            for column in 0..y.ncols() {
                for (map, _) in weights.of(range.start + column / items.rows) {
                    for entry in maps.width * map..maps.width * (map + 1) {
                        onto[(entry, column)] = maps.columns.col(entry).transpose() * y.col(column);
                    }
                }
            }
        }
    }
    onto
}

/// An item's maps and weights, strongest first, and its squared error.
type FittedItem = (Vec<(usize, f64)>, f64);

fn fit_item(
    items: &Items<'_>,
    item: usize,
    products: &Mat<f64>,
    onto: &Mat<f64>,
    block_start: usize,
    supports: Supports<'_>,
) -> FittedItem {
    let m = items.width;
    let maps = products.ncols() / m;
    let rows = item * items.rows..(item + 1) * items.rows;
    let own: f64 = rows.clone().map(|row| norm2(items.y.col_as_slice(row))).sum();
    let product = |a: usize, b: usize| -> f64 {
        let mut sum = 0.0;
        for row in rows.clone() {
            let h = items.row(row);
            for j in 0..m {
                let column = &products.col_as_slice(b * m + j)[a * m..(a + 1) * m];
                let inner: f64 = column.iter().zip(h).map(|(p, x)| p * x).sum();
                sum += inner * h[j];
            }
        }
        sum
    };
    let toward = |a: usize| -> f64 {
        let mut sum = 0.0;
        for row in rows.clone() {
            let column = onto.col_as_slice(row - block_start * items.rows);
            sum += column[a * m..].iter().zip(items.row(row)).map(|(p, x)| p * x).sum::<f64>();
        }
        sum
    };
    let alone = |map: usize| {
        let c = toward(map);
        (product(map, map) - 2.0 * c + own, c, map)
    };
    let mut candidates: Vec<(f64, f64, usize)> = match supports {
        Supports::Free(..) => (0..maps).map(alone).collect(),
        Supports::Fixed(weights) => weights.of(item).map(|(map, _)| alone(map)).collect(),
    };
    if candidates.len() > CANDIDATES {
        candidates
            .select_nth_unstable_by(CANDIDATES, |a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        candidates.truncate(CANDIDATES);
    }
    if let Supports::Free(_, Some(kept)) = supports {
        for (map, _) in kept.of(item) {
            if candidates.len() < MAX_COLUMNS && candidates.iter().all(|c| c.2 != map) {
                candidates.push(alone(map));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));

    let mut gram = Gram {
        len: candidates.len(),
        noise: ROUNDING * own,
        value: [[0.0; MAX_COLUMNS]; MAX_COLUMNS],
    };
    for (i, &(error, toward_a, a)) in candidates.iter().enumerate() {
        gram.value[i][i] = error.max(0.0);
        for (j, &(_, toward_b, b)) in candidates.iter().enumerate().take(i) {
            let value = product(a, b) - toward_a - toward_b + own;
            gram.value[i][j] = value;
            gram.value[j][i] = value;
        }
    }
    let weights = simplex::solve_sparse(&gram, supports.most());
    let mut list: Vec<(usize, f64)> = (0..gram.len)
        .filter(|&i| weights[i] > 0.0)
        .map(|i| (candidates[i].2, weights[i]))
        .collect();
    list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    (list, gram.error(&weights))
}

/// Fits the maps to given weights; a map moves from `previous` only as far as the items ask.
///
/// - `pull`: weight of the proximal term, as a share of the mean diagonal. It decides what no item
///   determines (a map without items, the direction out of a flat patch) and keeps the system positive
///   definite.
pub fn fit_maps(items: &Items<'_>, weights: &Weights, previous: &Maps, pull: f64) -> Maps {
    let m = items.width;
    let (size, rank) = (previous.columns.ncols(), items.y.nrows());
    let chunk = items.len().div_ceil(CHUNKS).max(1);
    let parts: Vec<(Mat<f64>, Mat<f64>)> = (0..items.len().div_ceil(chunk))
        .into_par_iter()
        .map(|c| {
            let mut normal = Mat::zeros(size, size);
            let mut right = Mat::zeros(rank, size);
            for item in c * chunk..((c + 1) * chunk).min(items.len()) {
                for row in item * items.rows..(item + 1) * items.rows {
                    accumulate(items, row, weights.of(item), item, normal.as_mut(), right.as_mut());
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
    right += faer::Scale(proximal) * &previous.columns;
    let columns = match normal.llt(Side::Lower) {
        Ok(factor) => factor.solve(right.transpose()).transpose().to_owned(),
        // Only rounding could make it indefinite; the maps then stay as they are.
        Err(_) => previous.columns.clone(),
    };
    Maps { width: m, columns }
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
    let y = items.y.col_as_slice(row);
    let counts = items.importance.of(item);
    for (a, wa) in weights.clone() {
        for (j, hj) in h.iter().enumerate() {
            let phi = counts * wa * hj;
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

fn norm2(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Items that known maps and known weights move exactly.
    fn exact(count: usize, rank: usize) -> (Vec<f64>, Mat<f64>, Maps, Vec<[f64; 3]>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let columns = Mat::from_fn(rank, 3 * 4, |_, _| random.random_range(-1.0..1.0));
        let mut h = Vec::new();
        let mut y = Mat::zeros(rank, count);
        let mut weights = Vec::new();
        for item in 0..count {
            let x: [f64; 4] =
                std::array::from_fn(|k| if k == 3 { 1.0 } else { random.random_range(-1.0..1.0) });
            let a: f64 = random.random_range(0.0..1.0);
            let b: f64 = random.random_range(0.0..1.0 - a);
            let w = [a, b, 1.0 - a - b];
            for row in 0..rank {
                y[(row, item)] = (0..12).map(|k| w[k / 4] * x[k % 4] * columns[(row, k)]).sum();
            }
            h.extend(x);
            weights.push(w);
        }
        (h, y, Maps { width: 4, columns }, weights)
    }

    #[test]
    fn true_maps_give_back_the_true_weights() {
        let (h, y, maps, truth) = exact(300, 30);
        let items = Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE };
        let (weights, errors) = fit_weights(&items, &maps, Supports::Free(3, None));
        assert!(errors.iter().all(|&e| e < 1e-9));
        let (again, errors) = fit_weights(&items, &maps, Supports::Fixed(&weights));
        assert!(errors.iter().all(|&e| e < 1e-9));
        assert!((0..300).all(|i| again.of(i).map(|w| w.0).eq(weights.of(i).map(|w| w.0))));
        for (item, expected) in truth.iter().enumerate() {
            let found: Vec<_> = weights.of(item).collect();
            assert!(found.is_sorted_by(|a, b| a.1 >= b.1), "strongest first");
            for (map, weight) in found {
                assert!((weight - expected[map]).abs() < 1e-6, "item {item}");
            }
        }
    }

    #[test]
    fn true_weights_give_back_the_true_maps() {
        let (h, y, maps, truth) = exact(300, 30);
        let items = Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE };
        let lists = truth.iter().map(|w| w.iter().copied().enumerate().collect());
        let start = Maps { width: 4, columns: Mat::zeros(30, 12) };
        let fitted = fit_maps(&items, &Weights::from_lists(3, lists), &start, 1e-7);
        assert!((fitted.columns - maps.columns).norm_max() < 1e-4);
    }

    #[test]
    fn a_map_that_no_item_uses_stays_where_it_was() {
        let (h, y, maps, truth) = exact(50, 30);
        let items = Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE };
        let lists = truth.iter().map(|_| vec![(0, 1.0)]);
        let fitted = fit_maps(&items, &Weights::from_lists(1, lists), &maps, 1e-7);
        let moved = fitted.columns.subcols(4, 8) - maps.columns.subcols(4, 8);
        assert!(moved.norm_max() < 1e-12);
        assert!((fitted.columns.subcols(0, 4) - maps.columns.subcols(0, 4)).norm_max() > 1e-3);
    }
}
