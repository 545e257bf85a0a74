//! Items, the maps that they follow, and by which weights.

use crate::examples::Importance;
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
    /// How many times farther each map is from each item than the nearest, maps x items: of weights that err nearly as
    /// little those of nearer maps are taken. None where maps have no place, or the error alone is to tell.
    pub farther: Option<&'a Mat<f64>>,
}

impl<'a> Items<'a> {
    /// One row `[x̂ 1]` a vertex, with their trajectories r x V.
    pub fn vertices(rest: &[[f64; 3]], y: &'a Mat<f64>, importance: Importance<'a>) -> Self {
        let h = rest.iter().flat_map(|x| [x[0], x[1], x[2], 1.0]).collect();
        Self { width: 4, rows: 1, h, y, importance, farther: None }
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

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.h[row * self.width..(row + 1) * self.width]
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
