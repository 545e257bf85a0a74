//! The smooth map between two pictures of a layer, with the least difference of the pictures in both directions.

use super::affine::{Affine, ENOUGH};
use super::field::Field;
use super::lattice::{Bent, Lattice};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::{Matrix2, Vector2};

/// Cells along the longer side of the shape, and the blur as a part of its radius: coarse to fine.
const LEVELS: [(f64, f64); 4] = [(2.0, 12.0), (4.0, 24.0), (8.0, 48.0), (8.0, f64::INFINITY)];
/// Least blur, pixels.
const LEAST_BLUR: f64 = 0.7;
/// Room around the shape, of its longer side.
const ROOM: f64 = 0.25;
/// Weight of bending against the difference of two pictures apart.
const BENDING: f64 = 3e-3;
/// Steps a level.
const STEPS: usize = 20;
/// Share of the difference of two pictures apart below which a difference is none.
const EXACT: f64 = 1e-7;
/// Least area over the area before.
const LEAST_AREA: f64 = 0.05;
/// Largest distance of a place from its target, pixels.
const NEAR: f64 = 0.5;

/// Finds the smooth map from a picture to another.
///
/// - `starts`: affine maps to start from. At each level the worse half is left behind.
pub(super) fn bent(rest: &Field, other: &Field, starts: &[Affine]) -> Option<Bent> {
    let radius = rest.moments().radius();
    let size = Vector2::from(rest.size.map(|len| len as f64));
    let room = Vector2::repeat(ROOM * size.max());
    let (low, high) = (rest.corner - room, rest.corner + size + room);
    let lattice = |cells: f64| Lattice::new(low, high, cells * (1.0 + 2.0 * ROOM));
    let first = |start: &Affine| Bent::of(lattice(LEVELS[0].0), |place| start.at(place));
    let mut maps: Vec<(&Affine, Bent)> = starts.iter().map(|start| (start, first(start))).collect();
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
            let mut map = Bent::of(lattice(cells), |place| map.at(place).0);
            let error = improved(&fields, &mut map, start, sigma);
            tried.push((start.cost(error), start, map));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        tried.truncate(tried.len().div_ceil(2));
        maps = tried.into_iter().map(|(_, start, map)| (start, map)).collect();
    }
    maps.into_iter().next().map(|(_, map)| map)
}

/// A place of a picture with its difference from the other, and the slopes of that along the moved place.
struct Difference {
    place: Vector2<f64>,
    square: Matrix2<f64>,
    right: Vector2<f64>,
}

/// Differences of a map and their sum.
struct Tried {
    error: f64,
    bending: f64,
    differences: Vec<Difference>,
    /// Where the other picture's places come from.
    sources: Vec<Vector2<f64>>,
}

/// Improves a map by damped steps of Gauss and Newton, and returns its difference and bending over the difference
/// of two pictures apart.
fn improved(fields: &[Field; 2], map: &mut Bent, start: &Affine, sigma: f64) -> f64 {
    let step = ((sigma / 1.5) as usize).max(1);
    let places = fields.each_ref().map(|field| field.places(step));
    let square = |rgba: &[f64; 4]| rgba.iter().map(|x| x * x).sum::<f64>();
    let whole: f64 = places.iter().flatten().map(|(_, rgba)| square(rgba)).sum();
    let whole = whole.max(f64::MIN_POSITIVE);
    let rows = map.lattice.differences();
    let tried = |map: &Bent, guesses: &[Vector2<f64>]| {
        let mut out =
            Tried { error: 0.0, bending: 0.0, differences: Vec::new(), sources: Vec::new() };
        for (place, rgba) in places[0].iter().filter(|(place, _)| map.lattice.is_within(*place)) {
            let (found, slopes) = fields[1].sample(map.at(*place).0);
            out.add(*place, |k| (rgba[k] - found[k], slopes[k]));
        }
        for ((place, rgba), guess) in places[1].iter().zip(guesses) {
            let own = map.back(*place, *guess);
            out.sources.push(own);
            let (found, slope) = map.at(own);
            let is_there = (found - place).norm() < NEAR
                && slope.determinant() > LEAST_AREA
                && map.lattice.is_within(own);
            match slope.try_inverse().filter(|_| is_there) {
                // Pixels that nothing comes to be are missed as a whole.
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
    let (mut now, mut damping) = (tried(map, &guesses), 1e-4);
    'steps: for _ in 0..STEPS {
        let (matrix, right) = equations(map, &now, &rows, BENDING * whole);
        let mean = (0..right.nrows()).map(|k| matrix[(k, k)]).sum::<f64>() / right.nrows() as f64;
        loop {
            let mut damped = matrix.clone();
            (0..right.nrows()).for_each(|k| damped[(k, k)] += damping * mean);
            let Ok(factor) = damped.llt(Side::Lower) else { break 'steps };
            let found = factor.solve(&right);
            let mut next = map.clone();
            for (k, node) in next.nodes.iter_mut().enumerate() {
                *node += Vector2::new(found[(2 * k, 0)], found[(2 * k + 1, 0)]);
            }
            let tried = tried(&next, &now.sources);
            let [before, after] = [&now, &tried].map(|own| own.error + own.bending);
            if after < before {
                (*map, now, damping) = (next, tried, (0.1 * damping).max(1e-6));
                if before - after < ENOUGH * before + EXACT * whole {
                    break 'steps;
                }
                break;
            }
            damping *= 10.0;
            if damping > 1e2 {
                break 'steps;
            }
        }
    }
    (now.error + now.bending) / whole
}

impl Tried {
    /// Adds a place: by channel its difference, and the slope of that along the moved place.
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

/// Makes the normal equations of a step; nodes' x and y alternate, and the matrix is filled below its diagonal.
fn equations(
    map: &Bent,
    tried: &Tried,
    rows: &[Vec<(usize, f64)>],
    bending: f64,
) -> (Mat<f64>, Mat<f64>) {
    let len = 2 * map.lattice.len();
    let (mut matrix, mut right) = (Mat::zeros(len, len), Mat::zeros(len, 1));
    for Difference { place, square, right: own } in &tried.differences {
        let around = map.lattice.around(*place);
        for (a, by) in around.weights.into_iter().enumerate() {
            let first = 2 * map.lattice.node(around.first, a);
            right[(first, 0)] += by * own.x;
            right[(first + 1, 0)] += by * own.y;
            for (b, other) in around.weights.into_iter().enumerate().take(a + 1) {
                let second = 2 * map.lattice.node(around.first, b);
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
