//! A small rasteriser: z-buffer, smooth shading, four samples a pixel.

use super::camera::{Camera, Resolution};
use super::colour::Colour;
use super::picture::Picture;
use crate::numeric::columns::{ends, largest};
use nalgebra::Vector3;

/// Samples along each side of a pixel.
const SAMPLES: usize = 2;
/// Directions (right, up, toward the eye) and shares of the key light and the fill light. The remaining light is
/// ambient.
const LIGHTS: [([f64; 3], f64); 2] = [([-0.45, 0.65, 0.62], 0.66), ([0.75, 0.15, 0.64], 0.24)];
/// Ambient light, and how much of it depends on facing up.
const AMBIENT: (f64, f64) = (0.27, 0.06);
/// Factor that darkens the inside of an open mesh.
const INSIDE: f64 = 0.55;

/// A surface to draw.
#[derive(Clone, Copy)]
pub struct ShadedMesh<'a> {
    /// Positions, V.
    pub positions: &'a [[f64; 3]],
    /// Normals, V; at a zero normal the triangle's normal is used.
    pub normals: &'a [[f64; 3]],
    /// Vertex indices of each triangle.
    pub triangles: &'a [[usize; 3]],
}

/// How a surface shows its colours.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Strength of light and shadow, in [0, 1].
    pub relief: f64,
    /// Whether every point has the colour of its nearest corner, so that colours meet at sharp borders.
    pub borders: bool,
}

/// The visible point of the surface at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle.
    pub triangle: usize,
    /// Barycentric coordinates, one a corner.
    pub weights: [f64; 3],
    /// Distance toward the eye.
    pub depth: f64,
}

impl ShadedMesh<'_> {
    /// Draws the surface with one colour a vertex, V.
    pub fn draw(&self, colours: &[Colour], look: Look, camera: &Camera) -> Picture {
        let hits = self.hits(&camera.resized(SAMPLES as f64));
        let linear: Vec<[f64; 3]> =
            colours.iter().map(|c| c.map(|part| to_linear(f64::from(part)))).collect();
        let steps = steps();
        let Resolution { width, height } = camera.size;
        let mut rgba = Vec::with_capacity(4 * width * height);
        for pixel in 0..width * height {
            let (x, y) = (SAMPLES * (pixel % width), SAMPLES * (pixel / width));
            let mut sum = [0.0; 3];
            let mut covered = 0_usize;
            for sample in 0..SAMPLES * SAMPLES {
                let (x, y) = (x + sample % SAMPLES, y + sample / SAMPLES);
                let Some(hit) = &hits[y * SAMPLES * width + x] else { continue };
                let light = 1.0 - look.relief * (1.0 - self.light(hit, camera));
                let colour = match look.borders {
                    true => linear[self.nearest(hit)],
                    false => self.mix(hit, &linear),
                };
                sum = [0, 1, 2].map(|c| sum[c] + light * colour[c]);
                covered += 1;
            }
            let colour = match covered {
                0 => [0; 3],
                _ => sum.map(|part| from_linear(part / covered as f64, &steps)),
            };
            let alpha = 255 * covered / (SAMPLES * SAMPLES);
            rgba.extend([colour[0], colour[1], colour[2], alpha as u8]);
        }
        Picture { size: camera.size, rgba }
    }

    /// Returns whether the surface hides a vertex by more than `slack`, or the vertex lies outside the picture.
    pub fn hides(&self, vertex: usize, slack: f64, camera: &Camera) -> bool {
        let [x, y, depth] = camera.project(&self.positions[vertex]);
        let Resolution { width, height } = camera.size;
        if !(x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64) {
            return true;
        }
        let seen = self.hits(camera)[y as usize * width + x as usize];
        seen.is_some_and(|hit| hit.depth > depth + slack)
    }

    /// Sums a quantity of the vertices (V) over the visible outside, pixel by pixel.
    pub fn seen(&self, numbers: &[f64], camera: &Camera) -> f64 {
        let at = |hit: &Hit| {
            if self.face(hit).dot(&camera.axes[2]) < 0.0 {
                return 0.0;
            }
            let corners = self.triangles[hit.triangle].iter().zip(hit.weights);
            corners.map(|(&vertex, weight)| weight * numbers[vertex]).sum::<f64>()
        };
        self.hits(camera).iter().flatten().map(at).sum()
    }

    /// Finds the visible point at the centre of every pixel, row by row.
    pub fn hits(&self, camera: &Camera) -> Vec<Option<Hit>> {
        let Resolution { width, height } = camera.size;
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

    /// Returns the vertex of the corner with the largest weight.
    fn nearest(&self, hit: &Hit) -> usize {
        self.triangles[hit.triangle][largest(&hit.weights)]
    }

    /// Interpolates values of the vertices.
    fn mix(&self, hit: &Hit, of: &[[f64; 3]]) -> [f64; 3] {
        let corners = self.triangles[hit.triangle];
        [0, 1, 2].map(|c| (0..3).map(|k| hit.weights[k] * of[corners[k]][c]).sum())
    }

    /// Returns the outward normal of the triangle, as long as twice its area.
    fn face(&self, hit: &Hit) -> Vector3<f64> {
        let corners = self.triangles[hit.triangle].map(|v| Vector3::from(self.positions[v]));
        (corners[1] - corners[0]).cross(&(corners[2] - corners[0]))
    }

    fn light(&self, hit: &Hit, camera: &Camera) -> f64 {
        let face = self.face(hit);
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

/// Returns twice the area of a triangle in the picture.
fn cross(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the pixels whose centre may lie between the corners.
fn span(corners: [f64; 3], len: usize) -> std::ops::Range<usize> {
    let [low, high] = ends(&corners);
    // The cast clamps a negative or huge number to the integer range.
    let (first, end) = ((low - 0.5).ceil() as usize, (high + 0.5).floor() as usize);
    first.min(len)..end.min(len)
}

/// Converts a byte of sRGB to linear light, in [0, 1].
fn to_linear(byte: f64) -> f64 {
    let part = byte / 255.0;
    if part <= 0.040_45 { part / 12.92 } else { libm::pow((part + 0.055) / 1.055, 2.4) }
}

/// Returns the byte whose light is nearest; `steps` are the borders between successive bytes.
fn from_linear(part: f64, steps: &[f64]) -> u8 {
    steps.partition_point(|step| *step <= part) as u8
}

/// Returns the light half-way between each byte and the next, 255 values.
fn steps() -> Vec<f64> {
    (0..255).map(|byte| to_linear(f64::from(byte) + 0.5)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera whose pixels are model units, x to the right and y down from the upper left corner.
    fn camera(width: usize, height: usize) -> Camera {
        Camera {
            axes: [Vector3::x(), -Vector3::y(), Vector3::z()],
            centre: [0.5 * width as f64, -0.5 * height as f64],
            scale: 1.0,
            size: Resolution { width, height },
        }
    }

    fn mesh<'a>(positions: &'a [[f64; 3]], triangles: &'a [[usize; 3]]) -> ShadedMesh<'a> {
        ShadedMesh { positions, normals: &[[0.0; 3]; 6], triangles }
    }

    const FLAT: Look = Look { relief: 0.0, borders: false };
    const RED: Colour = [200, 10, 30];
    const BLUE: Colour = [5, 60, 220];

    fn pixel(picture: &Picture, x: usize, y: usize) -> [u8; 4] {
        let first = 4 * (y * picture.size.width + x);
        [0, 1, 2, 3].map(|part| picture.rgba[first + part])
    }

    #[test]
    fn a_triangle_covers_the_pixels_whose_centre_lies_inside() {
        let corners = [[0.2, 0.2, 0.0], [8.2, 0.2, 0.0], [0.2, 8.2, 0.0]];
        for triangle in [[0, 1, 2], [0, 2, 1]] {
            let hits = mesh(&corners, &[triangle]).hits(&camera(10, 9));
            for (place, hit) in hits.iter().enumerate() {
                let (x, y) = ((place % 10) as f64 + 0.5, (place / 10) as f64 + 0.5);
                assert_eq!(hit.is_some(), x > 0.2 && y > 0.2 && x + y < 8.4, "{x} {y}");
                let Some(hit) = hit else { continue };
                let shares = triangle.map(|vertex| match vertex {
                    0 => 1.0 - (x - 0.2 + y - 0.2) / 8.0,
                    1 => (x - 0.2) / 8.0,
                    _ => (y - 0.2) / 8.0,
                });
                assert!((0..3).all(|k| (hit.weights[k] - shares[k]).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn nearer_hides_farther_in_any_order() {
        let corners = [
            [0.0, 0.0, 1.0],
            [9.0, 0.0, 1.0],
            [0.0, 9.0, 1.0],
            [0.0, 0.0, 2.0],
            [4.0, 0.0, 2.0],
            [0.0, 4.0, 0.0],
        ];
        let colours = [BLUE, BLUE, BLUE, RED, RED, RED];
        for triangles in [[[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]] {
            let picture = mesh(&corners, &triangles).draw(&colours, FLAT, &camera(9, 9));
            // The second triangle falls from depth 2 at the top to 0 at y = 4, through the first at y = 2.
            assert_eq!(pixel(&picture, 0, 0)[..3], RED);
            assert_eq!(pixel(&picture, 0, 1)[..3], RED);
            assert_eq!(pixel(&picture, 0, 2)[..3], BLUE);
            assert_eq!(pixel(&picture, 5, 1)[..3], BLUE);
        }
        let both = mesh(&corners, &[[0, 1, 2], [3, 4, 5]]);
        assert!(both.hides(0, 0.5, &camera(9, 9)) && !both.hides(3, 0.5, &camera(9, 9)));
        assert!(!both.hides(0, 2.0, &camera(9, 9)));
    }

    #[test]
    fn colours_are_exact_blend_in_linear_light_or_meet_at_a_border() {
        let corners = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0]];
        let whole = mesh(&corners, &[[0, 1, 2]]);
        let plain = whole.draw(&[RED; 3], FLAT, &camera(40, 40));
        assert_eq!(pixel(&plain, 7, 9), [RED[0], RED[1], RED[2], 255]);
        assert_eq!(pixel(&plain, 39, 39)[3], 0);
        // Three of the four samples of a pixel on the diagonal lie on the diagonal or on its near side.
        assert_eq!(pixel(&plain, 20, 19)[3], 191);

        let ends = [[0, 0, 0], [255, 255, 255], [0, 0, 0]];
        let blended = whole.draw(&ends, FLAT, &camera(40, 40));
        // Half the light is 188 in sRGB: 0.5 = ((188 / 255 + 0.055) / 1.055)^2.4.
        assert!((184..=188).contains(&pixel(&blended, 19, 5)[0]));
        assert!((188..=192).contains(&pixel(&blended, 20, 5)[0]));
        let kinds = Look { borders: true, ..FLAT };
        let kinds = whole.draw(&ends, kinds, &camera(40, 40));
        assert_eq!((pixel(&kinds, 18, 1)[0], pixel(&kinds, 21, 1)[0]), (0, 255));
    }

    #[test]
    fn light_comes_from_the_upper_left_and_the_inside_is_darker() {
        let corners = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]];
        let shade = |normal: [f64; 3], triangle: [usize; 3]| {
            let normals = [normal; 3];
            let mesh =
                ShadedMesh { positions: &corners, normals: &normals, triangles: &[triangle] };
            let look = Look { relief: 1.0, borders: false };
            pixel(&mesh.draw(&[[128; 3]; 3], look, &camera(9, 9)), 1, 1)[0]
        };
        // y points down in this camera, so a triangle that winds left in the picture shows its outside.
        let outside = [0, 1, 2];
        let [left, right] = [[-0.6, -0.5, 0.6], [0.6, 0.5, 0.6]].map(|n| shade(n, outside));
        assert!(left > right, "{left} {right}");
        assert!(shade([0.0, 0.0, 1.0], outside) > shade([0.0, 0.0, -1.0], [0, 2, 1]));
        // Without a vertex normal, the triangle's normal is used.
        assert_eq!(shade([0.0; 3], outside), shade([0.0, 0.0, 1.0], outside));
    }

    #[test]
    fn only_the_visible_outside_counts() {
        let corners = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]];
        let seen = |triangle| mesh(&corners, &[triangle]).seen(&[3.0; 3], &camera(9, 9));
        // Pixel centres with x + y <= 8: 8 + 7 + … + 1.
        assert_eq!(seen([0, 1, 2]).max(seen([0, 2, 1])), 3.0 * 36.0);
        assert_eq!(seen([0, 1, 2]).min(seen([0, 2, 1])), 0.0);
    }
}
