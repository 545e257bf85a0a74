//! Items, maps, and the weights of items on maps.

use crate::examples::Importance;
use faer::Mat;
use std::borrow::Cow;

/// Items of a blend. Their maps are side by side in a matrix, r x (l·m): columns l·m..l·m+m are map l.
pub struct Items<'a> {
    /// Width m of a row.
    pub width: usize,
    /// Rows per item.
    pub rows: usize,
    /// Rows h, items x rows x m.
    pub h: Vec<f64>,
    /// Targets, r x (items·rows).
    pub y: &'a Mat<f64>,
    /// Importance of each item in the fit of maps.
    pub importance: Importance<'a>,
    /// Pull of the weights to prior weights; `None` if only the error decides.
    pub pull: Option<Pull<'a>>,
    /// Weights of the items on further, fixed maps, and these maps, r x (l·m). [`fit_maps`](super::fit_maps) fits the
    /// open maps to the rest of the motion.
    pub fixed: Option<(&'a Weights, &'a Mat<f64>)>,
}

impl<'a> Items<'a> {
    /// Creates items of `width` and `rows`, without a pull and without fixed maps.
    pub fn new(
        [width, rows]: [usize; 2],
        h: Vec<f64>,
        y: &'a Mat<f64>,
        importance: Importance<'a>,
    ) -> Self {
        Self { width, rows, h, y, importance, pull: None, fixed: None }
    }

    /// Creates an item with one row `[x̂ 1]` for each vertex.
    ///
    /// - `y`: trajectories, r x V.
    pub fn vertices(rest: &[[f64; 3]], y: &'a Mat<f64>, importance: Importance<'a>) -> Self {
        let h = rest.iter().flat_map(|x| [x[0], x[1], x[2], 1.0]).collect();
        Self::new([4, 1], h, y, importance)
    }

    /// Returns the number of items.
    pub(super) fn len(&self) -> usize {
        self.y.ncols() / self.rows
    }

    /// Sums errors of the items, weighted by importance.
    pub fn sum(&self, errors: &[f64]) -> f64 {
        errors.iter().enumerate().map(|(item, error)| self.importance.of(item) * error).sum()
    }

    /// Returns the target of a row minus its motion by the fixed maps.
    pub(super) fn target(&self, row: usize) -> Cow<'_, [f64]> {
        let y = self.y.col_as_slice(row);
        let Some((weights, maps)) = self.fixed else { return Cow::Borrowed(y) };
        let blended = weights.blend(row / self.rows, self.row(row), maps);
        Cow::Owned(y.iter().zip(blended).map(|(y, blended)| y - blended).collect())
    }

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.h[row * self.width..(row + 1) * self.width]
    }
}

/// Pull of weights w to prior weights p. Weights on joints have the cost `λ Σ_j (w_j - p_j)² / (p_j + ε)`.
#[derive(Clone, Copy)]
pub struct Pull<'a> {
    /// Prior weights p on joints, joints x items; the weights of an item sum to 1.
    pub to: &'a Mat<f64>,
    /// Joint of each map, l. Weights on maps of one joint add up.
    pub joints: &'a [usize],
    /// λ, in squared units of the targets.
    pub strength: f64,
}

/// Terms of a map in the cost of the pull.
#[derive(Clone, Copy, Default)]
pub(super) struct PullTerm {
    joint: usize,
    linear: f64,
    square: f64,
}

impl PullTerm {
    /// Returns the inner product of two maps in the cost of an item, without the constant part. The item's weights sum
    /// to 1.
    pub(super) fn product(&self, other: &Self) -> f64 {
        let square = if self.joint == other.joint { self.square } else { 0.0 };
        square - self.linear - other.linear
    }
}

/// ε: prior weights below this count as 0.
const FOREIGN: f64 = 1e-4;

impl Pull<'_> {
    /// Returns the constant part of an item's cost.
    pub(super) fn constant(&self, item: usize) -> f64 {
        let squares = self.to.col_as_slice(item).iter().map(|p| p * p / (p + FOREIGN));
        self.strength * squares.sum::<f64>()
    }

    /// Returns the terms of a map in the cost of an item.
    pub(super) fn of(&self, item: usize, map: usize) -> PullTerm {
        let joint = self.joints[map];
        let p = self.to[(joint, item)];
        let square = self.strength / (p + FOREIGN);
        PullTerm { joint, linear: square * p, square }
    }
}

/// Weights of items on maps, at most K an item.
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
    pub(crate) fn len(&self) -> usize {
        self.entries.len() / self.most
    }

    /// Returns the maps and weights of an item with a weight above 0, strongest first.
    pub fn of(&self, item: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let entries = &self.entries[item * self.most..(item + 1) * self.most];
        entries.iter().take_while(|e| e.1 > 0.0).map(|&(map, weight)| (map as usize, weight))
    }

    /// Returns the map with the largest weight of an item; `None` if all weights are 0.
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

    /// Blends the maps of an item and applies the blend to a row of m numbers. Returns r numbers.
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

    /// Gives the maps other indices.
    pub(crate) fn renumbered(&self, place: impl Fn(usize) -> usize) -> Self {
        let of = |item| self.of(item).map(|(map, weight)| (place(map), weight)).collect();
        Self::from_lists(self.most, (0..self.len()).map(of))
    }

    /// Creates weights from a list of (map, weight) for each item, strongest first. A list has at most `most` entries.
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

/// Maps that items may follow.
#[derive(Clone, Copy)]
pub enum Supports<'a> {
    /// At most this number of maps. The candidates are the maps with the least cost alone.
    Free(usize),
    /// Like `Free`, with the maps of some other weights as further candidates. An item keeps the maps of its last
    /// weights if they cost less.
    Better {
        /// Largest number of maps of an item.
        most: usize,
        /// Weights that give further candidates.
        others: &'a Weights,
        /// Weights of the last round.
        last: &'a Weights,
    },
    /// The maps that items follow by the given weights.
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
