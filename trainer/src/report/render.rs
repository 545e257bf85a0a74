//! A small rasteriser: z-buffer, smooth shading, four samples a pixel.

use super::camera::{Camera, Size};
use super::colour::Colour;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use nalgebra::Vector3;

/// Samples along each side of a pixel.
const SAMPLES: usize = 2;
/// Directions of the key and the fill light, to the right, up and toward the eye, and their shares;
/// the rest comes from everywhere.
const LIGHTS: [([f64; 3], f64); 2] = [([-0.45, 0.65, 0.62], 0.62), ([0.75, 0.15, 0.64], 0.2)];
/// Light that comes from everywhere, more of it from above.
const AMBIENT: (f64, f64) = (0.2, 0.05);
/// How much darker the inside of an open mesh is.
const INSIDE: f64 = 0.55;

/// A surface to draw.
#[derive(Clone, Copy)]
pub struct Mesh<'a> {
    /// V positions.
    pub positions: &'a [[f64; 3]],
    /// V normals; where one is zero, the triangle's serves.
    pub normals: &'a [[f64; 3]],
    /// Vertex numbers.
    pub triangles: &'a [[usize; 3]],
}

/// A point of the surface that is seen at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle.
    pub triangle: usize,
    /// Share of each corner.
    pub weights: [f64; 3],
    /// Distance toward the eye.
    pub depth: f64,
}

/// Pixels from the upper left, row by row: red, green, blue, and how far each is covered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: Size,
    /// Pixels, 4 bytes each.
    pub rgba: Vec<u8>,
}

impl Mesh<'_> {
    /// Draws the surface in V colours. `relief` in [0, 1] says how far light and shadow change them.
    pub fn draw(&self, colours: &[Colour], relief: f64, camera: &Camera) -> Picture {
        let hits = self.hits(&camera.resized(SAMPLES as f64));
        let linear: Vec<[f64; 3]> = colours.iter().map(|c| c.map(to_linear)).collect();
        let Size { width, height } = camera.size;
        let mut rgba = Vec::with_capacity(4 * width * height);
        for pixel in 0..width * height {
            let (x, y) = (SAMPLES * (pixel % width), SAMPLES * (pixel / width));
            let mut sum = [0.0; 3];
            let mut covered = 0;
            for sample in 0..SAMPLES * SAMPLES {
                let (x, y) = (x + sample % SAMPLES, y + sample / SAMPLES);
                let Some(hit) = &hits[y * SAMPLES * width + x] else { continue };
                let light = 1.0 - relief + relief * self.light(hit, camera);
                let colour = self.mix(hit, &linear);
                sum = [0, 1, 2].map(|c| sum[c] + light * colour[c]);
                covered += 1;
            }
            let colour = sum.map(|part| from_linear(part / f64::from(covered.max(1))));
            let alpha = 255 * covered as usize / (SAMPLES * SAMPLES);
            rgba.extend([colour[0], colour[1], colour[2], alpha as u8]);
        }
        Picture { size: camera.size, rgba }
    }

    /// Adds up a number a vertex over all that is seen, in pixels.
    pub fn seen(&self, numbers: &[f64], camera: &Camera) -> f64 {
        let at = |hit: &Hit| {
            let corners = self.triangles[hit.triangle].iter().zip(hit.weights);
            corners.map(|(&vertex, weight)| weight * numbers[vertex]).sum::<f64>()
        };
        self.hits(camera).iter().flatten().map(at).sum()
    }

    /// Finds what is seen at the middle of every pixel, row by row.
    pub fn hits(&self, camera: &Camera) -> Vec<Option<Hit>> {
        let Size { width, height } = camera.size;
        let mut hits: Vec<Option<Hit>> = vec![None; width * height];
        let seen: Vec<[f64; 3]> = self.positions.iter().map(|p| camera.project(p)).collect();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let corners = corners.map(|vertex| seen[vertex]);
            let [a, b, c] = corners;
            let area = cross(a, b, c);
            if area == 0.0 || !area.is_finite() {
                continue;
            }
            for y in span(corners.map(|corner| corner[1]), height) {
                for x in span(corners.map(|corner| corner[0]), width) {
                    let p = [x as f64 + 0.5, y as f64 + 0.5, 0.0];
                    let weights =
                        [cross(b, c, p), cross(c, a, p), cross(a, b, p)].map(|w| w / area);
                    if weights.iter().any(|weight| *weight < 0.0) {
                        continue;
                    }
                    let depth = (0..3).map(|k| weights[k] * corners[k][2]).sum();
                    let nearest = &mut hits[y * width + x];
                    if nearest.is_none_or(|hit| hit.depth < depth) {
                        *nearest = Some(Hit { triangle, weights, depth });
                    }
                }
            }
        }
        hits
    }

    fn mix(&self, hit: &Hit, of: &[[f64; 3]]) -> [f64; 3] {
        let corners = self.triangles[hit.triangle];
        [0, 1, 2].map(|c| (0..3).map(|k| hit.weights[k] * of[corners[k]][c]).sum())
    }

    fn light(&self, hit: &Hit, camera: &Camera) -> f64 {
        let corners = self.triangles[hit.triangle].map(|v| Vector3::from(self.positions[v]));
        let face = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let normal = Vector3::from(self.mix(hit, self.normals));
        let normal = normal.try_normalize(1e-9).or_else(|| face.try_normalize(0.0));
        let mut normal = normal.unwrap_or_default();
        let inside = face.dot(&camera.axes[2]) < 0.0;
        if inside {
            normal = -normal;
        }
        let [right, up, toward] = camera.axes.map(|axis| axis.dot(&normal));
        let mut light = AMBIENT.0 + AMBIENT.1 * up;
        for ([x, y, z], share) in LIGHTS {
            let length = (x * x + y * y + z * z).sqrt();
            light += share * ((right * x + up * y + toward * z) / length).max(0.0);
        }
        if inside { INSIDE * light } else { light }
    }
}

impl Picture {
    /// Encodes the picture as PNG.
    ///
    /// # Errors
    /// Those of the encoder.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        let Size { width, height } = self.size;
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(&self.rgba, width as u32, height as u32, ExtendedColorType::Rgba8)?;
        Ok(bytes)
    }
}

/// Twice the area of a triangle in the picture.
fn cross(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The pixels whose middle may lie between the corners.
fn span(corners: [f64; 3], len: usize) -> std::ops::Range<usize> {
    let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A negative or huge number becomes the nearest one that an integer can hold.
    let (first, end) = ((low - 0.5).ceil() as usize, (high + 0.5).floor() as usize);
    first.min(len)..end.min(len)
}

fn to_linear(part: u8) -> f64 {
    let part = f64::from(part) / 255.0;
    if part <= 0.040_45 { part / 12.92 } else { libm::pow((part + 0.055) / 1.055, 2.4) }
}

fn from_linear(part: f64) -> u8 {
    let part = part.clamp(0.0, 1.0);
    let part =
        if part <= 0.003_130_8 { 12.92 * part } else { 1.055 * libm::pow(part, 1.0 / 2.4) - 0.055 };
    (255.0 * part).round() as u8
}
