//! Finds the smooth map between two pictures of a layer that minimises their difference in both directions. Maps are
//! uniform cubic B-splines over a lattice.

use super::affine::{Affine, Field, improved};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::{Matrix2, Vector2};

/// Levels from coarse to fine: number of cells along the longer side of the shape, and the radius of the shape over the
/// blur.
const LEVELS: [(f64, f64); 4] = [(2.0, 12.0), (4.0, 24.0), (8.0, 48.0), (8.0, f64::INFINITY)];
/// Smallest blur, pixels.
const LEAST_BLUR: f64 = 0.7;
/// Margin around the shape, over its longer side.
const ROOM: f64 = 0.25;
/// Weight of bending, over the difference of two disjoint pictures.
const BENDING: f64 = 3e-3;
/// Largest number of steps at a level.
const STEPS: usize = 20;
/// Smallest improvement of a step, over the difference of two disjoint pictures.
const EXACT: f64 = 1e-7;
/// Smallest determinant of the map's derivative.
const LEAST_AREA: f64 = 0.05;
/// Largest distance of a mapped place from its target, pixels.
const NEAR: f64 = 0.5;

/// Finds the smooth map from a picture to another.
///
/// - `starts`: affine maps to start from. Each level drops the worse half.
pub(super) fn smooth_map(rest: &Field, other: &Field, starts: &[Affine]) -> Option<SplineMap> {
    let radius = rest.moments().radius();
    let size = Vector2::from(rest.size.map(|len| len as f64));
    let room = Vector2::repeat(ROOM * size.max());
    let (low, high) = (rest.corner - room, rest.corner + size + room);
    let lattice = |cells: f64| Lattice::new(low, high, cells * (1.0 + 2.0 * ROOM));
    let first = |start: &Affine| SplineMap::of(lattice(LEVELS[0].0), |place| start.at(place));
    let mut maps: Vec<(&Affine, SplineMap)> =
        starts.iter().map(|start| (start, first(start))).collect();
    let mut last = None;
    for (cells, by) in LEVELS {
        let level = (cells, (radius / by).max(LEAST_BLUR));
        if last.replace(level) == Some(level) {
            continue;
        }
        let sigma = level.1;
        let fields = [rest.blurred(sigma), other.blurred(sigma)];
        let mut tried = Vec::new();
        for (start, map) in maps {
            let map = SplineMap::of(lattice(cells), |place| map.at(place).0);
            let (map, error) = fitted(&fields, map, start, sigma);
            tried.push((start.cost(error), start, map));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        tried.truncate(tried.len().div_ceil(2));
        maps = tried.into_iter().map(|(_, start, map)| (start, map)).collect();
    }
    maps.into_iter().next().map(|(_, map)| map)
}

/// Normal equations of one place: squared slopes along the mapped place, and slopes times difference.
struct Difference {
    place: Vector2<f64>,
    square: Matrix2<f64>,
    right: Vector2<f64>,
}

/// Differences of a map, and their sum.
struct Tried {
    error: f64,
    bending: f64,
    differences: Vec<Difference>,
    /// Places that map to the other picture's places.
    sources: Vec<Vector2<f64>>,
}

/// Improves a map by damped Gauss-Newton steps. Returns the map with its difference and bending, over the difference of
/// two disjoint pictures.
fn fitted(fields: &[Field; 2], map: SplineMap, start: &Affine, sigma: f64) -> (SplineMap, f64) {
    let step = ((sigma / 1.5) as usize).max(1);
    let places = fields.each_ref().map(|field| field.places(step));
    let square = |rgba: &[f64; 4]| rgba.iter().map(|x| x * x).sum::<f64>();
    let whole: f64 = places.iter().flatten().map(|(_, rgba)| square(rgba)).sum();
    let whole = whole.max(f64::MIN_POSITIVE);
    let rows = map.lattice.differences();
    let tried = |map: &SplineMap, guesses: &[Vector2<f64>]| {
        let mut out =
            Tried { error: 0.0, bending: 0.0, differences: Vec::new(), sources: Vec::new() };
        for (place, rgba) in places[0].iter().filter(|(place, _)| map.lattice.is_within(*place)) {
            let (found, slopes) = fields[1].sample(map.at(*place).0);
            out.add(*place, |k| (rgba[k] - found[k], slopes[k]));
        }
        for ((place, rgba), guess) in places[1].iter().zip(guesses) {
            let own = map.inverse_at(*place, *guess);
            out.sources.push(own);
            let (found, slope) = map.at(own);
            let is_there = (found - place).norm() < NEAR
                && slope.determinant() > LEAST_AREA
                && map.lattice.is_within(own);
            match slope.try_inverse().filter(|_| is_there) {
                // Pixels without a source count with their full value.
                None => out.error += square(rgba),
                Some(inverse) => {
                    let (found, slopes) = fields[0].sample(own);
                    let turned = inverse.transpose();
                    out.add(own, |k| (found[k] - rgba[k], turned * slopes[k]));
                }
            }
        }
        let sum = |row: &Vec<(usize, f64)>| {
            let sum: Vector2<f64> = row.iter().map(|(node, by)| *by * map.nodes[*node]).sum();
            sum.norm_squared()
        };
        out.bending = BENDING * whole * rows.iter().map(sum).sum::<f64>();
        out
    };
    let back = start.inverse();
    let guesses: Vec<Vector2<f64>> = places[1].iter().map(|(place, _)| back.at(*place)).collect();
    let system = |(map, now): &(SplineMap, Tried)| equations(map, now, &rows, BENDING * whole);
    let next = |(map, now): &(SplineMap, Tried), system: &(Mat<f64>, Mat<f64>), damping: f64| {
        let (matrix, right) = system;
        let mean = (0..right.nrows()).map(|k| matrix[(k, k)]).sum::<f64>() / right.nrows() as f64;
        let mut damped = matrix.clone();
        (0..right.nrows()).for_each(|k| damped[(k, k)] += damping * mean);
        let found = damped.llt(Side::Lower).ok()?.solve(right);
        let mut next = map.clone();
        for (k, node) in next.nodes.iter_mut().enumerate() {
            *node += Vector2::new(found[(2 * k, 0)], found[(2 * k + 1, 0)]);
        }
        let tried = tried(&next, &now.sources);
        Some((next, tried))
    };
    let first = tried(&map, &guesses);
    let error = |(_, now): &(SplineMap, Tried)| now.error + now.bending;
    let least = EXACT * whole;
    let found = improved((map, first), STEPS, [1e-4, 1e2], least, error, system, next);
    let error = error(&found) / whole;
    (found.0, error)
}

impl Tried {
    /// Adds a place.
    ///
    /// - `of`: difference of a channel, and its slope along the mapped place.
    fn add(&mut self, place: Vector2<f64>, of: impl Fn(usize) -> (f64, Vector2<f64>)) {
        let (mut square, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for k in 0..4 {
            let (error, slope) = of(k);
            self.error += error * error;
            square += slope * slope.transpose();
            right += slope * error;
        }
        if square != Matrix2::zeros() {
            self.differences.push(Difference { place, square, right });
        }
    }
}

/// Makes the normal equations of a step. The unknowns are x and y of each node in turn. Only the lower triangle of the
/// matrix is filled.
fn equations(
    map: &SplineMap,
    tried: &Tried,
    rows: &[Vec<(usize, f64)>],
    bending: f64,
) -> (Mat<f64>, Mat<f64>) {
    let len = 2 * map.lattice.len();
    let (mut matrix, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 1));
    for Difference { place, square, right: own } in &tried.differences {
        let (corner, weights) = map.lattice.weights_at(*place);
        for (a, by) in weights.into_iter().enumerate() {
            let first = 2 * map.lattice.node(corner, a);
            right[(first, 0)] += by * own.x;
            right[(first + 1, 0)] += by * own.y;
            for (b, other) in weights.into_iter().enumerate().take(a + 1) {
                let second = 2 * map.lattice.node(corner, b);
                let both = by * other;
                matrix[(first, second)] += both * square.m11;
                matrix[(first + 1, second)] += both * square.m21;
                matrix[(first + 1, second + 1)] += both * square.m22;
                if a != b {
                    matrix[(first, second + 1)] += both * square.m12;
                }
            }
        }
    }
    for row in rows {
        let sum: Vector2<f64> = row.iter().map(|(node, by)| *by * map.nodes[*node]).sum();
        for (a, by) in row {
            (0..2).for_each(|axis| right[(2 * a + axis, 0)] -= bending * by * sum[axis]);
            for (b, other) in row.iter().filter(|(b, _)| b <= a) {
                let both = bending * by * other;
                (0..2).for_each(|axis| matrix[(2 * a + axis, 2 * b + axis)] += both);
            }
        }
    }
    (matrix, right)
}

/// A lattice over a rectangle.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    origin: Vector2<f64>,
    /// Side of a cell.
    cell: f64,
    /// Number of nodes across and down: 3 more than cells.
    counts: [usize; 2],
}

/// A spline map: the coefficient of each node.
#[derive(Clone, Debug)]
pub(super) struct SplineMap {
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

    /// Returns the index of one of the 4 x 4 nodes around a place.
    pub(super) fn node(&self, first: usize, number: usize) -> usize {
        first + number / 4 * self.counts[0] + number % 4
    }

    /// Returns the nearest place inside the lattice.
    fn clamped(&self, place: Vector2<f64>) -> Vector2<f64> {
        let high = self.origin + self.extent();
        place.zip_map(&self.origin, f64::max).zip_map(&high, f64::min)
    }

    fn extent(&self) -> Vector2<f64> {
        Vector2::from(self.counts.map(|count| self.cell * (count - 3) as f64))
    }

    pub(super) fn is_within(&self, place: Vector2<f64>) -> bool {
        self.clamped(place) == place
    }

    /// Returns the cell of a place, and the position in the cell from 0 to 1.
    fn local(&self, place: Vector2<f64>) -> ([usize; 2], [f64; 2]) {
        let at = (place - self.origin) / self.cell;
        let cell = [0, 1].map(|axis| (at[axis].max(0.0) as usize).min(self.counts[axis] - 4));
        (cell, [0, 1].map(|axis| at[axis] - cell[axis] as f64))
    }

    /// Returns the index of the first of the 4 x 4 nodes around a place inside the lattice, and their weights by rows.
    fn weights_at(&self, place: Vector2<f64>) -> (usize, [f64; 16]) {
        let ([x, y], [s, t]) = self.local(place);
        let (across, down) = (spline(s), spline(t));
        let weights = std::array::from_fn(|k| down[k / 4] * across[k % 4]);
        (y * self.counts[0] + x, weights)
    }

    /// Lists the positions of the nodes.
    fn centres(&self) -> impl Iterator<Item = Vector2<f64>> {
        let columns = self.counts[0];
        (0..self.len()).map(move |node| {
            let at = Vector2::new((node % columns) as f64 - 1.0, (node / columns) as f64 - 1.0);
            self.origin + self.cell * at
        })
    }

    /// Lists second differences, each as nodes with weights. The sum of their squares is the bending of a map.
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

impl SplineMap {
    /// Approximates a map on a lattice. Affine maps are kept exactly.
    pub(super) fn of(lattice: Lattice, map: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Self {
        // Coefficients of cubic spline interpolation, truncated after the nearest neighbours.
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

    /// Returns the image of a place and the derivative there. Outside the lattice the map is extended linearly.
    pub(super) fn at(&self, place: Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let inside = self.lattice.clamped(place);
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

    /// Finds the place that maps to `target`, by Newton steps from a guess. Returns the last guess if there is no such
    /// place.
    pub(super) fn inverse_at(&self, target: Vector2<f64>, guess: Vector2<f64>) -> Vector2<f64> {
        let mut place = guess;
        for _ in 0..NEWTON {
            let (found, slope) = self.at(place);
            let Some(inverse) = slope.try_inverse() else { break };
            let step = inverse * (target - found);
            let len = step.norm().max(f64::MIN_POSITIVE);
            place += step * (2.0 * self.lattice.cell / len).min(1.0);
            let inside = self.lattice.clamped(place);
            place = inside + (place - inside).cap_magnitude(self.lattice.cell);
        }
        place
    }
}

/// Number of Newton steps.
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
    fn maps_have_inverses_and_derivatives() {
        let lattice = Lattice::new(Vector2::new(-3.0, 2.0), Vector2::new(17.0, 12.0), 5.0);
        let straight = |p: Vector2<f64>| Vector2::new(1.5 * p.x - 0.25 * p.y + 7.0, p.x + p.y);
        let kept = SplineMap::of(lattice.clone(), straight);
        for place in [[0.0, 3.0], [16.9, 11.9], [-9.0, 40.0]].map(Vector2::from) {
            let (found, slope) = kept.at(place);
            assert!((found - straight(place)).norm() < 1e-12);
            assert!((slope - Matrix2::new(1.5, -0.25, 1.0, 1.0)).norm() < 1e-12);
        }
        let bent = |p: Vector2<f64>| p + 0.02 * Vector2::new(p.y * p.y, p.x * p.y);
        let kept = SplineMap::of(lattice, bent);
        for place in [[0.0, 3.0], [8.0, 7.5], [12.0, 5.0]].map(Vector2::from) {
            // Cubic splines reproduce quadratic maps.
            assert!((kept.at(place).0 - bent(place)).norm() < 1e-12);
            let slope = Matrix2::new(1.0, 0.04 * place.y, 0.02 * place.y, 1.0 + 0.02 * place.x);
            assert!((kept.at(place).1 - slope).norm() < 1e-12);
            let back = kept.inverse_at(bent(place), Vector2::new(5.0, 5.0));
            assert!((back - place).norm() < 1e-6, "{back}");
        }
    }

    #[test]
    fn straight_maps_do_not_bend() {
        let lattice = Lattice::new(Vector2::zeros(), Vector2::new(9.0, 5.0), 4.0);
        let bending = |map: &dyn Fn(Vector2<f64>) -> Vector2<f64>| {
            let nodes = SplineMap::of(lattice.clone(), map).nodes;
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
