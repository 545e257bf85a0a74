//! Finds affine maps between two pictures of a layer, on blurred pictures with gradients.

use libm::{cos, exp, log, sin};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Number of start angles.
const ANGLES: usize = 16;
/// Weights of red, green, blue and alpha. Colours weigh little, so that a pattern that moves within a shape does not
/// turn the shape.
const WEIGHTS: [f64; 4] = [0.0625, 0.0625, 0.0625, 1.0];
/// Relative cost of a half turn. A turn must reduce the error, since round shapes look the same from all sides.
const TURN: f64 = 4.0;
/// Relative cost of uneven stretch, times the squared logarithm of the longest over the shortest stretch.
const STRETCH: f64 = 4.0;
/// Error below which all maps are equally good. The error of two disjoint pictures is 1.
const EQUAL: f64 = 0.001;
/// Highest cost of a kept map, over the smallest cost.
const LIKELY: f64 = 8.0;
/// Radius of the larger shape over the blur.
const BLUR: f64 = 6.0;
/// Number of steps from each start.
const STEPS: usize = 12;
/// Smallest determinant of a map.
const LEAST_AREA: f64 = 0.01;
/// Smallest relative improvement of a step.
const ENOUGH: f64 = 1e-4;

/// An affine map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine {
    /// Origin of the map.
    pub(super) from: Vector2<f64>,
    /// Image of `from`.
    pub(super) to: Vector2<f64>,
    /// Linear part of the map.
    pub(super) by: Matrix2<f64>,
}

impl Affine {
    pub(super) fn at(&self, place: Vector2<f64>) -> Vector2<f64> {
        self.by * (place - self.from) + self.to
    }

    /// Returns the cost of the map. The likeliest map has the smallest cost.
    ///
    /// - `error`: difference of the pictures, over the difference of two disjoint pictures.
    pub(super) fn cost(&self, error: f64) -> f64 {
        (error + EQUAL) * (1.0 + distortion(&self.by))
    }

    /// Returns the largest distance of two maps on a circle around their origin.
    fn distance(&self, other: &Self, radius: f64) -> f64 {
        (self.to - other.to).norm() + radius * (self.by - other.by).singular_values().max()
    }

    /// Returns the inverse map.
    pub(super) fn inverse(&self) -> Self {
        let by = self.by.try_inverse().unwrap_or_else(Matrix2::identity);
        Self { from: self.to, to: self.from, by }
    }
}

/// Finds affine maps from a picture to another, the likeliest first. Starts come from the moments, at all angles. Each
/// start then minimises the difference of the blurred pictures.
///
/// Outlines decide which map is likeliest. The other returned maps turn less, so that a pattern may prevent a turn but
/// never cause one: an iris moves in its eye.
pub(super) fn affine_maps(rest: &Field, other: &Field) -> Vec<Affine> {
    let [own, target] = [rest.moments(), other.moments()];
    // The blur scales with the larger shape.
    let sigma = (own.radius().max(target.radius()) / BLUR).max(1.0);
    let fields = [rest, other].map(|field| field.blurred(sigma));
    let found = |by: Matrix2<f64>| {
        let start = Affine { from: own.mean, to: target.mean, by };
        let (found, error) = fitted(&fields, start, sigma);
        (found.cost(error), found)
    };
    let mut all: Vec<(f64, Affine)> = starts(&own, &target).into_iter().map(found).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (least, likeliest) = all[0];
    let mut out = vec![likeliest];
    let others = all.into_iter().take_while(|(cost, _)| *cost <= LIKELY * least);
    for (_, map) in others.filter(|(_, map)| cosine(&map.by) > cosine(&likeliest.by)) {
        let is_new = out.iter().all(|other| map.distance(other, own.radius()) > sigma);
        if is_new {
            out.push(map);
        }
    }
    out
}

/// Lists the starts: scaled turns, and turns between maps that make both pictures round.
fn starts(own: &Moments, target: &Moments) -> Vec<Matrix2<f64>> {
    let root = |spread: Matrix2<f64>| {
        let eigen = spread.symmetric_eigen();
        let roots = Matrix2::from_diagonal(&eigen.eigenvalues.map(|x| x.max(0.0).sqrt()));
        eigen.eigenvectors * roots * eigen.eigenvectors.transpose()
    };
    let (from, to) = (root(own.spread), root(target.spread));
    let back = from.try_inverse().unwrap_or_else(Matrix2::identity);
    let scale = target.radius() / own.radius();
    let turn = |number: usize| {
        let angle = std::f64::consts::TAU * number as f64 / ANGLES as f64;
        let (sine, cosine) = (sin(angle), cos(angle));
        Matrix2::new(cosine, -sine, sine, cosine)
    };
    let turns = || (0..ANGLES).map(turn);
    turns().map(|turn| turn * scale).chain(turns().map(|turn| to * turn * back)).collect()
}

/// Returns the cost of the turn and the uneven stretch of a map; 0 for scales.
fn distortion(by: &Matrix2<f64>) -> f64 {
    let stretches = by.singular_values();
    let uneven = log(stretches.max() / stretches.min().max(f64::MIN_POSITIVE));
    0.5 * TURN * (1.0 - cosine(by)) + STRETCH * uneven * uneven
}

/// Returns the cosine of the rotation nearest to a map.
fn cosine(by: &Matrix2<f64>) -> f64 {
    let (along, across) = (by.m11 + by.m22, by.m21 - by.m12);
    along / along.hypot(across).max(f64::MIN_POSITIVE)
}

/// Improves a guess by damped Gauss-Newton steps, as long as its error falls.
///
/// - `damping`: first and largest damping.
/// - `least`: smallest improvement of a step, beside that of [`ENOUGH`].
/// - `system`: makes the equations of a guess.
/// - `next`: makes the guess after a step with a damping. `None` if the equations have no solution.
pub(super) fn improved<G, S>(
    mut now: G,
    steps: usize,
    [mut damping, most]: [f64; 2],
    least: f64,
    error: impl Fn(&G) -> f64,
    system: impl Fn(&G) -> S,
    next: impl Fn(&G, &S, f64) -> Option<G>,
) -> G {
    for _ in 0..steps {
        let system = system(&now);
        loop {
            let Some(found) = next(&now, &system, damping) else { return now };
            let [before, after] = [&now, &found].map(&error);
            if after < before {
                (now, damping) = (found, (0.1 * damping).max(1e-6));
                if before - after < ENOUGH * before + least {
                    return now;
                }
                break;
            }
            damping *= 10.0;
            if damping > most {
                return now;
            }
        }
    }
    now
}

/// Error of a map, and the normal equations of the next step.
#[derive(Clone, Copy)]
struct Tried {
    error: f64,
    matrix: SMatrix<f64, 6, 6>,
    right: SVector<f64, 6>,
}

/// Improves a map by damped Gauss-Newton steps. Returns the map and its error over that of two disjoint pictures.
fn fitted(fields: &[Field; 2], start: Affine, sigma: f64) -> (Affine, f64) {
    let step = ((sigma / 1.5) as usize).max(1);
    let places = fields.each_ref().map(|field| field.places(step));
    let square = |rgba: &[f64; 4]| (0..4).map(|k| WEIGHTS[k] * rgba[k].powi(2)).sum::<f64>();
    let whole: f64 = places.iter().flatten().map(|(_, rgba)| square(rgba)).sum();
    let tried = |map: &Affine| {
        let mut out = Tried { error: 0.0, matrix: SMatrix::zeros(), right: SVector::zeros() };
        let back = map.inverse();
        for (place, rgba) in &places[0] {
            let (found, slopes) = fields[1].sample(map.at(*place));
            out.add(*place - map.from, |k| (rgba[k] - found[k], slopes[k]));
        }
        for (place, rgba) in &places[1] {
            let own = back.at(*place);
            let (found, slopes) = fields[0].sample(own);
            out.add(own - map.from, |k| (found[k] - rgba[k], back.by.transpose() * slopes[k]));
        }
        out
    };
    let floor = |(_, now): &(Affine, Tried)| 1e-9 * now.matrix.trace() + 1e-12;
    let next = |(map, now): &(Affine, Tried), floor: &f64, damping: f64| {
        let mut matrix = now.matrix;
        (0..6).for_each(|k| matrix[(k, k)] += damping * (now.matrix[(k, k)] + floor));
        let found = matrix.cholesky()?.solve(&now.right);
        let by = map.by + Matrix2::new(found[0], found[1], found[2], found[3]);
        let next = Affine { by, to: map.to + Vector2::new(found[4], found[5]), ..*map };
        let is_allowed = by.determinant() > LEAST_AREA;
        let refused = Tried { error: f64::INFINITY, ..*now };
        Some((next, if is_allowed { tried(&next) } else { refused }))
    };
    let start = (start, tried(&start));
    let error = |(_, now): &(Affine, Tried)| now.error;
    let (map, now) = improved(start, STEPS, [1e-3, 1e3], 0.0, error, floor, next);
    (map, now.error / whole.max(f64::MIN_POSITIVE))
}

impl Tried {
    /// Adds a place.
    ///
    /// - `off`: offset of the place from the origin of the map.
    /// - `of`: difference of a channel, and its slope along the mapped place.
    fn add(&mut self, off: Vector2<f64>, of: impl Fn(usize) -> (f64, Vector2<f64>)) {
        for (k, weight) in WEIGHTS.into_iter().enumerate() {
            let (error, slope) = of(k);
            self.error += weight * error * error;
            if slope == Vector2::zeros() {
                continue;
            }
            let [x, y] = [slope.x, slope.y];
            let row = SVector::from([x * off.x, x * off.y, y * off.x, y * off.y, x, y]);
            self.matrix += weight * row * row.transpose();
            self.right += weight * error * row;
        }
    }
}

/// Radius of the Gaussian kernel, in standard deviations.
const REACH: f64 = 3.0;
/// Empty pixels around a blurred picture.
const MARGIN: usize = 2;

/// A picture of premultiplied RGBA from 0 to 1. Outside its edge nothing is covered.
#[derive(Clone)]
pub(super) struct Field {
    /// Position of the corner, pixels.
    pub(super) corner: Vector2<f64>,
    /// Width and height, pixels.
    pub(super) size: [usize; 2],
    rgba: Vec<[f64; 4]>,
}

/// Moments of the coverage of a picture.
#[derive(Clone, Copy)]
pub(super) struct Moments {
    /// Centre.
    pub(super) mean: Vector2<f64>,
    /// Second moments about the centre.
    pub(super) spread: Matrix2<f64>,
}

/// Values of the channels, and their derivatives in x and y.
pub(super) type Sample = ([f64; 4], [Vector2<f64>; 4]);

impl Field {
    /// Makes a field of a cropped picture with straight RGBA. Each pixel of the field is the mean of a square of
    /// pixels.
    ///
    /// - `side`: side of the squares, pixels. Places are divided by `side`.
    pub(super) fn new(
        rgba: &[u8],
        [width, height]: [usize; 2],
        corner: [usize; 2],
        side: usize,
    ) -> Self {
        let size = [width, height].map(|len| len.div_ceil(side));
        let mut means = vec![[0.0; 4]; size[0] * size[1]];
        for (at, pixel) in rgba.chunks(4).enumerate() {
            let mean = &mut means[at / width / side * size[0] + at % width / side];
            let alpha = f64::from(pixel[3]) / 255.0;
            (0..3).for_each(|channel| mean[channel] += alpha * f64::from(pixel[channel]) / 255.0);
            mean[3] += alpha;
        }
        let area = (side * side) as f64;
        means.as_flattened_mut().iter_mut().for_each(|sum| *sum /= area);
        let corner = Vector2::from(corner.map(|x| x as f64 / side as f64));
        Self { corner, size, rgba: means }
    }

    /// Shrinks the picture.
    ///
    /// - `scale`: factor of places, at most 1.
    pub(super) fn scaled(self, scale: f64) -> Self {
        if scale >= 1.0 {
            return self;
        }
        // The blur removes details between the new pixels.
        let blurred = self.blurred(0.4 / scale);
        let size = blurred.size.map(|len| (len as f64 * scale).ceil() as usize);
        let corner = blurred.corner * scale;
        let place = |at: usize| {
            let own = Vector2::new((at % size[0]) as f64 + 0.5, (at / size[0]) as f64 + 0.5);
            blurred.sample((corner + own) / scale).0
        };
        Self { corner, size, rgba: (0..size[0] * size[1]).map(place).collect() }
    }

    /// Blurs the picture by a Gaussian. The picture grows by the radius of the kernel.
    pub(super) fn blurred(&self, sigma: f64) -> Self {
        let reach = (REACH * sigma).ceil() as usize;
        let mut kernel: Vec<f64> = (0..=2 * reach)
            .map(|at| exp(-0.5 * ((at as f64 - reach as f64) / sigma).powi(2)))
            .collect();
        let sum: f64 = kernel.iter().sum();
        kernel.iter_mut().for_each(|weight| *weight /= sum);
        let [width, height] = self.size;
        let pad = reach + MARGIN;
        let size = self.size.map(|len| len + 2 * pad);
        let mut rows = vec![[0.0; 4]; size[0] * height];
        for (y, row) in self.rgba.chunks(width.max(1)).enumerate() {
            for (x, pixel) in row.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0.0) {
                let start = y * size[0] + x + MARGIN;
                spread(&mut rows, start, 1, &kernel, pixel);
            }
        }
        let mut rgba = vec![[0.0; 4]; size[0] * size[1]];
        for (at, pixel) in rows.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0.0) {
            spread(&mut rgba, at + MARGIN * size[0], size[0], &kernel, pixel);
        }
        let corner = self.corner - Vector2::repeat(pad as f64);
        Self { corner, size, rgba }
    }

    /// Samples the picture bilinearly between the centres of its pixels.
    pub(super) fn sample(&self, place: Vector2<f64>) -> Sample {
        let at = place - self.corner - Vector2::repeat(0.5);
        let [width, height] = self.size;
        let is_inside =
            at.x >= 0.0 && at.y >= 0.0 && at.x < width as f64 - 1.0 && at.y < height as f64 - 1.0;
        if !is_inside {
            return ([0.0; 4], [Vector2::zeros(); 4]);
        }
        let (x, y) = (at.x as usize, at.y as usize);
        let (fx, fy) = (at.x - x as f64, at.y - y as f64);
        let first = y * width + x;
        let [a, b] = [self.rgba[first], self.rgba[first + 1]];
        let [c, d] = [self.rgba[first + width], self.rgba[first + width + 1]];
        let mut out: Sample = Default::default();
        for k in 0..4 {
            let (top, bottom) = (a[k] + fx * (b[k] - a[k]), c[k] + fx * (d[k] - c[k]));
            out.0[k] = top + fy * (bottom - top);
            let across = (b[k] - a[k]) + fy * ((d[k] - c[k]) - (b[k] - a[k]));
            out.1[k] = Vector2::new(across, bottom - top);
        }
        out
    }

    /// Lists the centres of every `step`-th pixel across and down, with their values.
    pub(super) fn places(&self, step: usize) -> Vec<(Vector2<f64>, [f64; 4])> {
        let [width, height] = self.size;
        let rows = (0..height).step_by(step);
        let all = rows.flat_map(|y| (0..width).step_by(step).map(move |x| (x, y)));
        let place = |(x, y): (usize, usize)| {
            let own = self.corner + Vector2::new(x as f64 + 0.5, y as f64 + 0.5);
            (own, self.rgba[y * width + x])
        };
        all.map(place).collect()
    }

    /// Returns the moments of the coverage. A constant is added to the second moments, so that lines have a width.
    pub(super) fn moments(&self) -> Moments {
        let places = self.places(1);
        let mass: f64 = places.iter().map(|(_, rgba)| rgba[3]).sum();
        let mass = mass.max(f64::MIN_POSITIVE);
        let mean = places.iter().map(|(place, rgba)| place * rgba[3]).sum::<Vector2<f64>>() / mass;
        let square = |(place, rgba): &(Vector2<f64>, [f64; 4])| {
            let off = place - mean;
            off * off.transpose() * rgba[3]
        };
        let spread = places.iter().map(square).sum::<Matrix2<f64>>() / mass;
        Moments { mean, spread: spread + Matrix2::identity() * 0.1 }
    }
}

impl Moments {
    /// Returns the radius of the coverage: the root of the mean squared distance from the centre.
    pub(super) fn radius(&self) -> f64 {
        self.spread.trace().sqrt()
    }
}

/// Adds a pixel times a kernel to pixels `stride` apart.
fn spread(out: &mut [[f64; 4]], start: usize, stride: usize, kernel: &[f64], pixel: &[f64; 4]) {
    for (number, weight) in kernel.iter().enumerate() {
        let out = &mut out[start + number * stride];
        (0..4).for_each(|k| out[k] += weight * pixel[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_pixels_become_their_mean() {
        let pixel = |at: u8| [at, 0, 255, if at < 3 { 255 } else { 0 }];
        let rgba: Vec<u8> = (0..6).flat_map(pixel).collect();
        let own = Field::new(&rgba, [3, 2], [5, 8], 2);
        assert_eq!((own.size, own.corner), ([2, 1], Vector2::new(2.5, 4.0)));
        let expected = [[0.25 / 255.0, 0.0, 0.5, 0.5], [0.5 / 255.0, 0.0, 0.25, 0.25]];
        assert_eq!(own.rgba, expected);
        let plain = Field::new(&rgba, [3, 2], [5, 8], 1);
        assert_eq!((plain.rgba[1], plain.rgba[4]), ([1.0 / 255.0, 0.0, 1.0, 1.0], [0.0; 4]));
    }
}
