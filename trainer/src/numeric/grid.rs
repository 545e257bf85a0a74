//! Search for points near a place.

use nalgebra::Vector3;
use std::collections::HashMap;

/// Points in cells; a cell is as wide as the reach of the search.
pub(crate) struct Grid<'a> {
    /// The points.
    pub(crate) points: &'a [[f64; 3]],
    /// Largest distance of a near point.
    pub(crate) reach: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Grid<'a> {
    /// Sorts points into cells.
    pub(crate) fn new(points: &'a [[f64; 3]], reach: f64) -> Self {
        let reach = reach.max(f64::MIN_POSITIVE);
        let mut cells: HashMap<_, Vec<usize>> = HashMap::new();
        for (number, point) in points.iter().enumerate() {
            cells.entry(cell(point, reach)).or_default().push(number);
        }
        Self { points, reach, cells }
    }

    /// Returns the distance of a point from a place; infinity if there is no such point.
    pub(crate) fn distance(&self, number: usize, place: [f64; 3]) -> f64 {
        let apart = |point: &[f64; 3]| (Vector3::from(*point) - Vector3::from(place)).norm();
        self.points.get(number).map_or(f64::INFINITY, apart)
    }

    /// Lists the points within reach of a place, ascending.
    pub(crate) fn near(&self, place: [f64; 3]) -> Vec<usize> {
        let middle = cell(&place, self.reach);
        let mut found = Vec::new();
        for side in 0..27 {
            let step = [side % 3, side / 3 % 3, side / 9].map(|step| step - 1);
            let cell: [i64; 3] =
                std::array::from_fn(|axis| middle[axis].saturating_add(step[axis]));
            let own = self.cells.get(&cell).into_iter().flatten().copied();
            found.extend(own.filter(|&number| self.distance(number, place) <= self.reach));
        }
        found.sort_unstable();
        found
    }
}

fn cell(point: &[f64; 3], size: f64) -> [i64; 3] {
    point.map(|x| (x / size).floor() as i64)
}
