//! Smooth maps of the plane: uniform cubic B-splines over a lattice.

use nalgebra::{Matrix2, Vector2};

/// A lattice over a rectangle.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    origin: Vector2<f64>,
    /// The side of a cell.
    cell: f64,
    /// Nodes across and down: cells and 3.
    counts: [usize; 2],
}

/// Weights of the 4 x 4 nodes around a place, row by row from the node `first`.
pub(super) struct Around {
    pub(super) first: usize,
    pub(super) weights: [f64; 16],
}

/// A map: a place a node.
#[derive(Clone, Debug)]
pub(super) struct Bent {
    pub(super) lattice: Lattice,
    pub(super) nodes: Vec<Vector2<f64>>,
}

impl Lattice {
    /// Makes a lattice with about `cells` cells along the longer side of a rectangle.
    pub(super) fn new(low: Vector2<f64>, high: Vector2<f64>, cells: f64) -> Self {
        let sides = high - low;
        let cell = sides.max() / cells;
        let whole = sides.map(|side| (side / cell - 1e-9).ceil().max(1.0));
        let origin = 0.5 * (low + high - cell * whole);
        Self { origin, cell, counts: [whole.x as usize + 3, whole.y as usize + 3] }
    }

    pub(super) fn len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Returns the number of a node of the 4 x 4 around a place.
    pub(super) fn node(&self, first: usize, number: usize) -> usize {
        first + number / 4 * self.counts[0] + number % 4
    }

    /// Returns the nearest place within.
    fn within(&self, place: Vector2<f64>) -> Vector2<f64> {
        let high = self.origin + self.extent();
        place.zip_map(&self.origin, f64::max).zip_map(&high, f64::min)
    }

    fn extent(&self) -> Vector2<f64> {
        Vector2::from(self.counts.map(|count| self.cell * (count - 3) as f64))
    }

    pub(super) fn is_within(&self, place: Vector2<f64>) -> bool {
        self.within(place) == place
    }

    /// Returns the cell and the place in it, from 0 to 1.
    fn local(&self, place: Vector2<f64>) -> ([usize; 2], [f64; 2]) {
        let at = (place - self.origin) / self.cell;
        let cell = [0, 1].map(|axis| (at[axis].max(0.0) as usize).min(self.counts[axis] - 4));
        (cell, [0, 1].map(|axis| at[axis] - cell[axis] as f64))
    }

    /// Returns the weights at a place within.
    pub(super) fn around(&self, place: Vector2<f64>) -> Around {
        let ([x, y], [s, t]) = self.local(place);
        let (across, down) = (spline(s), spline(t));
        let weights = std::array::from_fn(|k| down[k / 4] * across[k % 4]);
        Around { first: y * self.counts[0] + x, weights }
    }

    /// Returns where each node lies.
    fn centres(&self) -> impl Iterator<Item = Vector2<f64>> {
        let columns = self.counts[0];
        (0..self.len()).map(move |node| {
            let at = Vector2::new((node % columns) as f64 - 1.0, (node / columns) as f64 - 1.0);
            self.origin + self.cell * at
        })
    }

    /// Lists second differences, each by nodes and their weights: the sum of their squares is the bending of a map.
    pub(super) fn differences(&self) -> Vec<Vec<(usize, f64)>> {
        let [columns, rows] = self.counts;
        let mut out = Vec::new();
        let by = 1.0 / self.cell;
        let mixed = std::f64::consts::SQRT_2 * by;
        for node in 0..self.len() {
            let (x, y) = (node % columns, node / columns);
            for (at, len, stride) in [(x, columns, 1), (y, rows, columns)] {
                if at > 0 && at + 1 < len {
                    out.push(vec![(node - stride, by), (node, -2.0 * by), (node + stride, by)]);
                }
            }
            if x + 1 < columns && y + 1 < rows {
                let across = [(node, mixed), (node + 1, -mixed)];
                let below = [(node + columns, -mixed), (node + columns + 1, mixed)];
                out.push([across, below].concat());
            }
        }
        out
    }
}

impl Bent {
    /// Takes a map over to a lattice; straight maps are kept exactly.
    pub(super) fn of(lattice: Lattice, map: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Self {
        // The interpolation of cubic splines, cut off after the nearest neighbours.
        let own = [-1.0 / 6.0, 8.0 / 6.0, -1.0 / 6.0];
        let node = |centre: Vector2<f64>| {
            let mut sum = Vector2::zeros();
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let off = Vector2::new(i as f64 - 1.0, j as f64 - 1.0) * lattice.cell;
                sum += own[i] * own[j] * map(centre + off);
            }
            sum
        };
        let nodes = lattice.centres().map(node).collect();
        Self { lattice, nodes }
    }

    /// Returns where a place comes to be and the derivative there; beyond the lattice the map is straight.
    pub(super) fn at(&self, place: Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let inside = self.lattice.within(place);
        let ([x, y], [s, t]) = self.lattice.local(inside);
        let (across, down) = (spline(s), spline(t));
        let [slope_across, slope_down] = [s, t].map(|t| slopes(t).map(|x| x / self.lattice.cell));
        let (mut found, mut slope) = (Vector2::zeros(), Matrix2::zeros());
        let first = y * self.lattice.counts[0] + x;
        for k in 0..16 {
            let node = self.nodes[self.lattice.node(first, k)];
            let (i, j) = (k % 4, k / 4);
            found += down[j] * across[i] * node;
            let turned = Vector2::new(down[j] * slope_across[i], slope_down[j] * across[i]);
            slope += node * turned.transpose();
        }
        (found + slope * (place - inside), slope)
    }

    /// Finds the place that comes to be at `target`, by Newton's steps from a guess; the last guess where there is none.
    pub(super) fn back(&self, target: Vector2<f64>, guess: Vector2<f64>) -> Vector2<f64> {
        let mut place = guess;
        for _ in 0..NEWTON {
            let (found, slope) = self.at(place);
            let Some(inverse) = slope.try_inverse() else { break };
            let step = inverse * (target - found);
            let len = step.norm().max(f64::MIN_POSITIVE);
            place += step * (2.0 * self.lattice.cell / len).min(1.0);
            let inside = self.lattice.within(place);
            place = inside + (place - inside).cap_magnitude(self.lattice.cell);
        }
        place
    }
}

/// Newton's steps from the last place to the next.
const NEWTON: usize = 4;

fn spline(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    let inner = |t: f64| (3.0 * t - 6.0) * t * t + 4.0;
    [u * u * u, inner(t), inner(u), t * t * t].map(|x| x / 6.0)
}

fn slopes(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    let inner = |t: f64| (3.0 * t - 4.0) * t;
    [-u * u, inner(t), -inner(u), t * t].map(|x| 0.5 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_kept_go_back_and_have_their_derivatives() {
        let lattice = Lattice::new(Vector2::new(-3.0, 2.0), Vector2::new(17.0, 12.0), 5.0);
        let straight = |p: Vector2<f64>| Vector2::new(1.5 * p.x - 0.25 * p.y + 7.0, p.x + p.y);
        let kept = Bent::of(lattice.clone(), straight);
        for place in [[0.0, 3.0], [16.9, 11.9], [-9.0, 40.0]].map(Vector2::from) {
            let (found, slope) = kept.at(place);
            assert!((found - straight(place)).norm() < 1e-12);
            assert!((slope - Matrix2::new(1.5, -0.25, 1.0, 1.0)).norm() < 1e-12);
        }
        let bent = |p: Vector2<f64>| p + 0.02 * Vector2::new(p.y * p.y, p.x * p.y);
        let kept = Bent::of(lattice, bent);
        for place in [[0.0, 3.0], [8.0, 7.5], [12.0, 5.0]].map(Vector2::from) {
            // Cubic splines hold quadratic maps.
            assert!((kept.at(place).0 - bent(place)).norm() < 1e-12);
            let slope = Matrix2::new(1.0, 0.04 * place.y, 0.02 * place.y, 1.0 + 0.02 * place.x);
            assert!((kept.at(place).1 - slope).norm() < 1e-12);
            let back = kept.back(bent(place), Vector2::new(5.0, 5.0));
            assert!((back - place).norm() < 1e-6, "{back}");
        }
    }

    #[test]
    fn straight_maps_do_not_bend() {
        let lattice = Lattice::new(Vector2::zeros(), Vector2::new(9.0, 5.0), 4.0);
        let bending = |map: &dyn Fn(Vector2<f64>) -> Vector2<f64>| {
            let nodes = Bent::of(lattice.clone(), map).nodes;
            let sum = |own: &Vec<(usize, f64)>| {
                own.iter().map(|(node, by)| *by * nodes[*node]).sum::<Vector2<f64>>()
            };
            lattice.differences().iter().map(|own| sum(own).norm_squared()).sum::<f64>()
        };
        assert!(bending(&|p| Vector2::new(2.0 * p.x - p.y, p.x + 3.0)) < 1e-20);
        assert!(bending(&|p| Vector2::new(p.x * p.y, 0.0)) > 1.0);
        assert!(bending(&|p| Vector2::new(p.x * p.x, 0.0)) > 1.0);
    }
}
