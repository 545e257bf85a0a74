//! Items, the maps that they follow, and by which weights.

use crate::examples::Importance;
use faer::Mat;
use std::borrow::Cow;

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
    /// The weights that theirs are pulled to; `None` if the error alone decides.
    pub pull: Option<Pull<'a>>,
    /// Fixed maps, r x (l·m), that also move the items, and the items' weights on them. [`fit_maps`](super::fit_maps) fits
    /// other maps to the rest of the motion.
    pub others: Option<(&'a Weights, &'a Mat<f64>)>,
}

impl<'a> Items<'a> {
    /// Items of `width` and `rows`, without a pull and without fixed maps.
    pub fn new(
        [width, rows]: [usize; 2],
        h: Vec<f64>,
        y: &'a Mat<f64>,
        importance: Importance<'a>,
    ) -> Self {
        Self { width, rows, h, y, importance, pull: None, others: None }
    }

    /// One row `[x̂ 1]` a vertex, with their trajectories r x V.
    pub fn vertices(rest: &[[f64; 3]], y: &'a Mat<f64>, importance: Importance<'a>) -> Self {
        let h = rest.iter().flat_map(|x| [x[0], x[1], x[2], 1.0]).collect();
        Self::new([4, 1], h, y, importance)
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

    /// Returns a row's target minus its motion by the fixed maps.
    pub(super) fn target(&self, row: usize) -> Cow<'_, [f64]> {
        let y = self.y.col_as_slice(row);
        let Some((weights, maps)) = self.others else { return Cow::Borrowed(y) };
        let blended = weights.blend(row / self.rows, self.row(row), maps);
        Cow::Owned(y.iter().zip(blended).map(|(y, blended)| y - blended).collect())
    }

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.h[row * self.width..(row + 1) * self.width]
    }
}

/// Prior weights that items' weights are pulled to: weights w on joints have the cost `λ Σ_j (w_j - p_j)² / (p_j + ε)`.
#[derive(Clone, Copy)]
pub struct Pull<'a> {
    /// Prior weights p on joints, joints x items; the weights of an item sum to 1.
    pub to: &'a Mat<f64>,
    /// Joint of each map; weights of maps of one joint add up. l.
    pub joints: &'a [usize],
    /// λ, in squared units of the targets.
    pub strength: f64,
}

/// A map in the cost of an item.
#[derive(Clone, Copy, Default)]
pub(super) struct Pulled {
    joint: usize,
    toward: f64,
    own: f64,
}

impl Pulled {
    /// Returns the inner product of two maps in the cost of an item, whose weights sum to 1, without its constant part.
    pub(super) fn product(&self, other: &Self) -> f64 {
        let same = if self.joint == other.joint { self.own } else { 0.0 };
        same - self.toward - other.toward
    }
}

/// ε: prior weight below which one joint is as foreign to an item as another.
const FOREIGN: f64 = 1e-4;

impl Pull<'_> {
    /// Returns the cost's constant part for an item.
    pub(super) fn constant(&self, item: usize) -> f64 {
        let squares = self.to.col_as_slice(item).iter().map(|p| p * p / (p + FOREIGN));
        self.strength * squares.sum::<f64>()
    }

    /// Returns a map in the cost of an item.
    pub(super) fn of(&self, item: usize, map: usize) -> Pulled {
        let joint = self.joints[map];
        let p = self.to[(joint, item)];
        let own = self.strength / (p + FOREIGN);
        Pulled { joint, toward: own * p, own }
    }
}

/// Maps side by side: r x (l·m).
#[derive(Clone)]
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

    /// Returns the weights on the first `len` maps as a matrix, len x items.
    pub fn dense(&self, len: usize) -> Mat<f64> {
        let mut dense = Mat::zeros(len, self.len());
        for item in 0..self.len() {
            self.of(item).for_each(|(map, weight)| dense[(map, item)] = weight);
        }
        dense
    }

    /// Blends the maps that an item follows, and applies them to a row of m numbers. Returns r numbers.
    ///
    /// - `maps`: r x (l·m).
    pub fn blend(&self, item: usize, row: &[f64], maps: &Mat<f64>) -> Vec<f64> {
        let mut out = vec![0.0; maps.nrows()];
        for (l, weight) in self.of(item) {
            for (c, x) in row.iter().enumerate() {
                let factor = weight * x;
                for (o, m) in out.iter_mut().zip(maps.col_as_slice(row.len() * l + c)) {
                    *o += factor * m;
                }
            }
        }
        out
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
    /// At most so many of those that come nearest by themselves.
    Free(usize),
    /// The same, or what some other weights follow, or just what the last weights do where that serves better.
    Better {
        /// At most so many.
        most: usize,
        /// Other weights.
        others: &'a Weights,
        /// The last weights.
        last: &'a Weights,
    },
    /// Those that they follow by these weights.
    Fixed(&'a Weights),
}

impl Supports<'_> {
    pub(super) fn most(&self) -> usize {
        match self {
            Self::Free(most) | Self::Better { most, .. } => *most,
            Self::Fixed(weights) => weights.most(),
        }
    }
}
