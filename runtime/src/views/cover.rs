//! Coverage of pixels by an element. Integer edge functions give each pixel on a shared edge to
//! exactly one neighbour. Borders cover a share of a pixel (METHOD §6.9).

use crate::numeric::{greater, lesser, sqrt};

/// A place on the screen, x to the right and y down, in 256ths of a pixel.
pub(super) type Step = [i64; 2];

/// Steps per pixel.
const PIXEL: i64 = 256;
/// Largest distance of a place from the screen's corner, in steps. With 2^20 pixels an edge
/// function stays below 2^60.
const STEPS_MAX: f32 = 268_435_456.0;

/// Snaps a place in pixels to steps. A place outside 2^20 pixels snaps to their edge.
pub(super) fn snap(place: [f32; 2]) -> Step {
    place.map(|x| {
        let steps = lesser(STEPS_MAX, greater(-STEPS_MAX, x * PIXEL as f32));
        libm::floorf(steps + 0.5) as i64
    })
}

/// Returns twice the area of the triangle a b c, positive where it turns clockwise on the screen.
pub(super) const fn area([ax, ay]: Step, [bx, by]: Step, [cx, cy]: Step) -> i64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Calls `each` for every covered pixel of a convex clockwise ring, row by row from the top.
///
/// The arguments are the pixel, its edge functions, and its covered share. Edge i runs from corner
/// i to the next corner. An edge function is twice the area of the triangle of the edge and the
/// pixel's centre.
///
/// A pixel is inside if its centre is inside. A centre on an edge is inside for left edges and
/// horizontal top edges. Across a soft edge coverage grows from 0 to 1 over the edge's width in
/// pixels, half of it outside.
pub(super) fn cover<const N: usize>(
    ring: &[Step; N],
    soft: [f32; N],
    [width, height]: [usize; 2],
    mut each: impl FnMut([usize; 2], [i64; N], f32),
) {
    let is_soft = soft.iter().any(|width| *width > 0.0);
    let beside = if is_soft { PIXEL / 2 } else { 0 };
    let (left, right) = span(ring.map(|[x, _]| x), beside, width);
    let (top, bottom) = span(ring.map(|[_, y]| y), beside, height);
    let mut edges = [Edge::default(); N];
    let ends = ring.iter().cycle().skip(1);
    for (((edge, from), to), soft) in edges.iter_mut().zip(ring).zip(ends).zip(soft) {
        *edge = Edge::new(*from, *to, soft);
    }
    for y in top..bottom {
        let start = [centre(left), centre(y)];
        let mut values = edges.map(|edge| edge.at(start));
        let mut has_begun = false;
        for x in left..right {
            if values.iter().zip(&edges).all(|(value, edge)| *value >= edge.least) {
                has_begun = true;
                let mut covered = 1.0;
                if is_soft {
                    let shares = values.iter().zip(&edges).map(|(value, edge)| edge.share(*value));
                    covered = shares.product();
                }
                each([x, y], values, covered);
            } else if has_begun {
                // A row of a convex ring is one run of pixels.
                break;
            }
            values.iter_mut().zip(&edges).for_each(|(value, edge)| *value += edge.across);
        }
    }
}

/// An edge function: 0 on the edge, positive inside.
#[derive(Clone, Copy, Default)]
struct Edge {
    from: Step,
    to: Step,
    /// Change from a pixel to its right neighbour.
    across: i64,
    /// Least value inside. For a soft edge: half its width outside. Otherwise 0 for an edge that
    /// owns the centres on it, or 1.
    least: i64,
    /// For a soft edge: widths per unit of the edge function; else 0.
    scale: f32,
}

impl Edge {
    fn new(from: Step, to: Step, soft: f32) -> Self {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let across = -dy * PIXEL;
        let length = sqrt(dx as f32 * dx as f32 + dy as f32 * dy as f32);
        // In units of the edge function.
        let width = soft * PIXEL as f32 * length;
        if width > 0.0 {
            let least = -(0.5 * width) as i64;
            return Self { from, to, across, least, scale: 1.0 / width };
        }
        let owns = dy < 0 || dy == 0 && dx > 0;
        Self { from, to, across, least: i64::from(!owns), scale: 0.0 }
    }

    const fn at(self, place: Step) -> i64 {
        area(self.from, self.to, place)
    }

    /// Returns the covered share of a pixel at this edge.
    #[inline(always)]
    fn share(&self, value: i64) -> f32 {
        if self.scale == 0.0 {
            return 1.0;
        }
        lesser(1.0, greater(0.0, value as f32 * self.scale + 0.5))
    }
}

/// Returns the range of pixels with centres between the least and the greatest coordinate, extended
/// by `beside` steps.
fn span<const N: usize>(coordinates: [i64; N], beside: i64, len: usize) -> (usize, usize) {
    let least = coordinates.iter().copied().min().unwrap_or_default() - beside;
    let greatest = coordinates.iter().copied().max().unwrap_or_default() + beside;
    // A pixel's centre is half a pixel from its start.
    let pixel = |step: i64| usize::try_from((step + PIXEL / 2).div_euclid(PIXEL)).unwrap_or(0);
    (pixel(least - 1).min(len), pixel(greatest).min(len))
}

const fn centre(pixel: usize) -> i64 {
    pixel as i64 * PIXEL + PIXEL / 2
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// Counts how often each pixel is covered.
    fn counted<const N: usize>(rings: &[[Step; N]], size: [usize; 2]) -> Vec<u32> {
        let mut counts = vec![0; size[0] * size[1]];
        for ring in rings {
            cover(ring, [0.0; N], size, |[x, y], _, share| {
                assert_eq!(share, 1.0);
                counts[y * size[0] + x] += 1;
            });
        }
        counts
    }

    /// Random numbers in [0, 1).
    fn random(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Corners of a grid of n x n cells over a square. Inner corners are moved at random, and every
    /// other one lies on a pixel's centre.
    fn grid(n: usize, size: usize) -> Vec<Vec<Step>> {
        let (mut seed, cell) = (3, size as f32 / n as f32);
        let mut place = |i: usize| {
            let moved = if i == 0 || i == n { 0.0 } else { 0.2 * (random(&mut seed) - 0.5) };
            cell * (i as f32 + moved)
        };
        let mut corner = |x: usize, y: usize| {
            let steps = snap([place(x), place(y)]);
            let inner = |i| i > 0 && i < n;
            let is_centred = (x + y).is_multiple_of(2) && inner(x) && inner(y);
            if is_centred { steps.map(|s| s / PIXEL * PIXEL + PIXEL / 2) } else { steps }
        };
        (0..=n).map(|y| (0..=n).map(|x| corner(x, y)).collect()).collect()
    }

    #[test]
    fn triangles_and_quads_cover_every_pixel_once() {
        for (n, size) in [(23, 512), (97, 512), (128, 512)] {
            let grid = grid(n, size);
            let (mut triangles, mut quads) = (Vec::new(), Vec::new());
            for (y, rows) in grid.windows(2).enumerate() {
                for x in 0..n {
                    let [a, b, c, d] = [rows[0][x], rows[0][x + 1], rows[1][x + 1], rows[1][x]];
                    match (x + y) % 3 {
                        0 => triangles.extend([[a, b, c], [a, c, d]]),
                        1 => triangles.extend([[a, b, d], [b, c, d]]),
                        _ => quads.push([a, b, c, d]),
                    }
                }
            }
            let sums = counted(&triangles, [size; 2]).into_iter();
            let sums = sums.zip(counted(&quads, [size; 2])).map(|(a, b)| a + b);
            assert!(sums.into_iter().all(|count| count == 1), "{n}");
        }
    }

    #[test]
    fn a_centre_on_an_edge_belongs_to_left_and_top_edges() {
        // Corners on centres: the square from 1.5 to 3.5 covers the centres of pixels 1 and 2, not
        // those of 3.
        let [low, high] = [centre(1), centre(3)];
        let square = [[low, low], [high, low], [high, high], [low, high]];
        let expected = [0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0];
        let found = counted(&[square], [5, 5]);
        assert_eq!(found[..15], expected);
        assert!(found[15..].iter().all(|count| *count == 0));
    }

    #[test]
    fn edge_functions_are_those_of_each_pixel() {
        let ring = [[-700, -300], [2000, 100], [300, 1900]];
        cover(&ring, [0.0; 3], [9, 9], |[x, y], values, _| {
            let p = [centre(x), centre(y)];
            let [a, b, c] = ring;
            assert_eq!(values, [area(a, b, p), area(b, c, p), area(c, a, p)]);
        });
        assert!(counted(&[ring], [9, 9]).contains(&1));
    }

    #[test]
    fn soft_edges_cover_shares_of_pixels_as_areas_do() {
        // A rotated square, cut in two along a hard diagonal: both areas sum to the square's area.
        let turned = |x: f32, y: f32| snap([20.3 + 0.8 * x - 0.6 * y, 19.7 + 0.6 * x + 0.8 * y]);
        let [a, b, c, d] =
            [turned(-9.0, -9.0), turned(9.0, -9.0), turned(9.0, 9.0), turned(-9.0, 9.0)];
        let mut shares = vec![0.0f32; 1600];
        for (ring, soft) in [([a, b, c], [1.0, 1.0, 0.0]), ([a, c, d], [0.0, 1.0, 1.0])] {
            cover(&ring, soft, [40; 2], |[x, y], _, share| shares[40 * y + x] += share);
        }
        assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)));
        let sum: f32 = shares.iter().sum();
        assert!((sum - 324.0).abs() < 1.5, "{sum}");
        // Compare each pixel's share with the share of 16 x 16 samples inside, up to the width of a
        // one-pixel filter.
        for (at, share) in shares.iter().enumerate() {
            let inside = (0..256).filter(|sample| {
                let x = (at % 40) as f32 + ((sample % 16) as f32 + 0.5) / 16.0 - 20.3;
                let y = (at / 40) as f32 + ((sample / 16) as f32 + 0.5) / 16.0 - 19.7;
                let own = [0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x];
                own.iter().all(|x| x.abs() < 9.0)
            });
            let area = inside.count() as f32 / 256.0;
            assert!((area - share).abs() < 0.13, "{at}: {area} {share}");
        }
    }

    #[test]
    fn far_and_flat_elements_are_handled() {
        let far = [[-9e9, -9e9], [9e9, -9e9], [0.0, f32::MAX]].map(snap);
        assert!(counted(&[far], [8, 8]).iter().all(|count| *count == 1));
        let flat = [[0.0, 0.0], [4.0, 4.0], [8.0, 8.0]].map(snap);
        assert!(counted(&[flat], [8, 8]).iter().all(|count| *count == 0));
        let beside = [[-9.0, 1.0], [-1.0, 1.0], [-9.0, 7.0]].map(snap);
        assert!(counted(&[beside], [8, 8]).iter().all(|count| *count == 0));
        assert_eq!(snap([f32::NAN, 0.25])[1], 64);
    }
}
