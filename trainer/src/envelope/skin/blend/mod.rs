//! Blends of maps: the least-squares problem that LBS weights, proxies and keys share.
//!
//! An item (a vertex, a triangle) has one or more rows h of width m with a target trajectory y in
//! R^r each; l maps `M_l` (r x m) are blended with weights w: `y ≈ Σ_l w_l M_l h`, w ≥ 0, Σw = 1,
//! at most K of them not zero. Weights and maps are fitted in turn (METHOD §1.2, §1.7).

mod maps;
mod weights;

pub use maps::fit_maps;
pub use weights::{CANDIDATES, fit_weights};

use crate::examples::Importance;
use crate::progress::Progress;
use faer::Mat;

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

    /// Returns whether an item follows the same maps by both.
    pub fn follow_alike(&self, other: &Self, item: usize) -> bool {
        let both = self.of(item).filter(|(map, _)| other.of(item).any(|own| own.0 == *map));
        let count = both.count();
        count == self.of(item).count() && count == other.of(item).count()
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
    /// The first for some items, the second for the others.
    Some {
        /// Whether each item is free.
        free: &'a [bool],
        /// Most maps.
        most: usize,
        /// Others that a free item may follow.
        kept: &'a Weights,
        /// What the others follow.
        fixed: &'a Weights,
    },
}

impl<'a> Supports<'a> {
    fn most(&self) -> usize {
        match self {
            Self::Free(most, _) | Self::Some { most, .. } => *most,
            Self::Fixed(weights) => weights.most(),
        }
    }

    /// What an item may follow: one of the first two.
    fn of(self, item: usize) -> Self {
        match self {
            Self::Some { free, most, kept, .. } if free[item] => Self::Free(most, Some(kept)),
            Self::Some { fixed, .. } => Self::Fixed(fixed),
            _ => self,
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
    fn an_item_that_is_not_free_keeps_what_it_follows() {
        let (h, y, maps, _) = exact(300, 30);
        let items = Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE };
        let first = Weights::from_lists(2, (0..300).map(|i| vec![(i % 2, 1.0)]));
        let free: Vec<bool> = (0..300).map(|i| i % 3 == 0).collect();
        let supports = Supports::Some { free: &free, most: 2, kept: &first, fixed: &first };
        let (some, errors) = fit_weights(&items, &maps, supports);
        let (all, least) = fit_weights(&items, &maps, Supports::Free(2, Some(&first)));
        for item in 0..300 {
            if free[item] {
                assert!(some.of(item).eq(all.of(item)) && errors[item] == least[item]);
            } else {
                assert!(some.follow_alike(&first, item) && errors[item] >= least[item]);
            }
        }
        assert!((0..300).any(|item| !all.follow_alike(&first, item)));
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
