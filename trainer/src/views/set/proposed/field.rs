//! Pictures as functions of the place: blurred, sampled with their gradients.

use libm::exp;
use nalgebra::{Matrix2, Vector2};

/// Where a Gaussian ends, in its standard deviations.
const REACH: f64 = 3.0;
/// Pixels without coverage around a picture, beyond the reach of its blur.
const MARGIN: usize = 2;

/// A picture of premultiplied RGBA from 0 to 1; it covers nothing beyond its edge.
#[derive(Clone)]
pub(super) struct Field {
    /// x and y of the corner.
    pub(super) corner: Vector2<f64>,
    /// Width and height.
    pub(super) size: [usize; 2],
    rgba: Vec<[f64; 4]>,
}

/// Moments of a picture's coverage.
#[derive(Clone, Copy)]
pub(super) struct Moments {
    /// The centre.
    pub(super) mean: Vector2<f64>,
    /// Second moments about the centre.
    pub(super) spread: Matrix2<f64>,
}

/// A value and the derivatives of each channel in x and y.
pub(super) type Sample = ([f64; 4], [Vector2<f64>; 4]);

impl Field {
    /// Takes a cropped picture, straight RGBA: the mean of each square of pixels.
    ///
    /// - `side`: of a square, pixels; places are divided by it.
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
    /// - `scale`: at most 1; places are multiplied by it.
    pub(super) fn scaled(self, scale: f64) -> Self {
        if scale >= 1.0 {
            return self;
        }
        // Blurred so far that no detail lies between the new pixels.
        let blurred = self.blurred(0.4 / scale);
        let size = blurred.size.map(|len| (len as f64 * scale).ceil() as usize);
        let corner = blurred.corner * scale;
        let place = |at: usize| {
            let own = Vector2::new((at % size[0]) as f64 + 0.5, (at / size[0]) as f64 + 0.5);
            blurred.sample((corner + own) / scale).0
        };
        Self { corner, size, rgba: (0..size[0] * size[1]).map(place).collect() }
    }

    /// Blurs the picture by a Gaussian; it grows by the reach of the blur.
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

    /// Samples the picture linearly between the centres of its pixels.
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

    /// Lists places, a pixel's centre in each `step` pixels across and down, with their values.
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

    /// Returns the moments of the coverage; a little is added to the second, so that lines have a width.
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
    /// Returns the radius of the coverage: the root of its mean squared distance from the centre.
    pub(super) fn radius(&self) -> f64 {
        self.spread.trace().sqrt()
    }
}

/// Adds a pixel times a kernel to places `stride` apart.
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
