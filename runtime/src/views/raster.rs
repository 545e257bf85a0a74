//! Elements onto a screen: textures mapped and blended, by depth or by order (METHOD §6.9).

use super::blend::SOURCES;
use super::cover::{Step, area, cover, snap};
use super::texture::{ALPHA_MAX, Colour, Texture};
use crate::lanes::{Eight, Lanes, ROUND, Real};
use crate::numeric::{greater, lesser, sqrt};
use glam::Vec4;

/// A corner of an element.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// Where it is on the screen, in pixels, y down.
    pub(super) place: [f32; 2],
    /// How far it is from the viewer.
    pub(super) depth: f32,
    /// Which of the element's corners it is.
    pub(super) number: usize,
    /// Over how many pixels the edge from here to the next corner fades out: 1 of a border, 0 of an edge within.
    pub(super) soft: f32,
}

/// What an element has its colours from: a texture, where the element's corners are in it, and its share of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source<'a> {
    pub(super) texture: Texture<'a>,
    pub(super) texels: [[f32; 2]; 4],
    pub(super) share: f32,
}

/// A picture that elements are drawn to, over what it holds.
pub(super) struct Screen<'a> {
    pub(super) width: usize,
    /// RGBA8, colours times their alpha, row by row from the top.
    pub(super) pixels: &'a mut [[u8; 4]],
    /// How far each pixel is; without them elements are blended, one over the other.
    pub(super) depths: Option<&'a mut [f32]>,
    /// Of what is drawn, from 0 to 1.
    pub(super) opacity: f32,
    /// Whether it holds one layer alone: no pixel is more opaque than the most opaque element there.
    pub(super) is_group: bool,
}

impl Screen<'_> {
    fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len().checked_div(self.width).unwrap_or(0)]
    }

    /// Whether a pixel would show anything that far away.
    #[inline(always)]
    fn shows(&self, at: usize, depth: f32) -> bool {
        let is_nearest = |depths: &[f32]| depths.get(at).is_some_and(|nearest| depth < *nearest);
        self.depths.as_deref().is_none_or(is_nearest)
    }

    /// Draws a colour at a pixel and a depth, on a share of the pixel.
    #[inline(always)]
    fn put(&mut self, at: usize, depth: f32, colour: Colour, covered: f32) {
        // What lies behind an edge that fades is seen beside it.
        if let Some(nearest) = self.depths.as_mut().and_then(|depths| depths.get_mut(at))
            && colour.w >= 0.5 * ALPHA_MAX
            && covered == 1.0
        {
            *nearest = depth;
        }
        if let Some(pixel) = self.pixels.get_mut(at) {
            *pixel = if self.is_group {
                joined(colour, covered, *pixel)
            } else {
                over(colour * (self.opacity * covered), *pixel)
            };
        }
    }
}

/// Draws a triangle whose texture is mapped affinely; returns whether it is flipped against its first source.
pub(super) fn triangle(
    screen: &mut Screen<'_>,
    corners: [Corner; 3],
    sources: &[Source<'_>],
) -> bool {
    let [a, b, c] = corners;
    let [p, q, r] = corners.map(|corner| snap(corner.place));
    let whole = area(p, q, r);
    let is_flipped = flips(whole, turn([a, b, c], sources));
    match whole {
        0 => {}
        1.. => clockwise_triangle(screen, [a, b, c], [p, q, r], sources),
        _ => clockwise_triangle(screen, reversed([a, b, c]), [p, r, q], sources),
    }
    is_flipped
}

/// Draws a quad whose texture is mapped bilinearly where it is convex on the screen, and as two triangles where it
/// is not; returns whether it is flipped against its first source, or folded.
pub(super) fn quad(screen: &mut Screen<'_>, corners: [Corner; 4], sources: &[Source<'_>]) -> bool {
    let [a, b, c, d] = corners;
    let ring = corners.map(|corner| snap(corner.place));
    let [p, q, r, s] = ring;
    let turns = [area(s, p, q), area(p, q, r), area(q, r, s), area(r, s, p)];
    let whole = turns.iter().sum::<i64>();
    let is_flipped = flips(whole, turn([a, b, c], sources) + turn([a, c, d], sources));
    // Corners at which it turns against itself; a straight one turns either way.
    let reflex = turns.map(|turn| flips(turn, whole as f32));
    // The edge that cuts it in two is no border.
    let inner = |corner: Corner| Corner { soft: 0.0, ..corner };
    match reflex {
        [false, false, false, false] => match whole {
            0 => {}
            1.. => clockwise_quad(screen, corners, ring, sources),
            _ => clockwise_quad(screen, reversed(corners), [p, s, r, q], sources),
        },
        [true, ..] | [_, _, true, _] => {
            triangle(screen, [a, b, inner(c)], sources);
            triangle(screen, [inner(a), c, d], sources);
        }
        _ => {
            triangle(screen, [a, inner(b), d], sources);
            triangle(screen, [b, c, inner(d)], sources);
        }
    }
    is_flipped || reflex.contains(&true)
}

/// Turns a ring round at its first corner; each edge goes with the corner that it now starts from.
fn reversed<const N: usize>(corners: [Corner; N]) -> [Corner; N] {
    let mut out = corners;
    out.reverse();
    out.rotate_right(1);
    let edges = corners.iter().rev().map(|corner| corner.soft);
    out.iter_mut().zip(edges).for_each(|(corner, soft)| corner.soft = soft);
    out
}

fn clockwise_triangle(
    screen: &mut Screen<'_>,
    corners: [Corner; 3],
    ring: [Step; 3],
    sources: &[Source<'_>],
) {
    let [p, q, r] = ring;
    let share = 1.0 / area(p, q, r) as f32;
    let size = screen.size();
    let soft = corners.map(|corner| corner.soft);
    let (own, len) = prepared(&corners, sources);
    let depths = corners.map(|corner| corner.depth);
    let at = |[a, b, c]: [f32; 3], s: f32, t: f32| a + (b - a) * s + (c - a) * t;
    cover(&ring, soft, size, |[x, y], [towards_c, _, towards_b], covered| {
        let (s, t) = (towards_b as f32 * share, towards_c as f32 * share);
        let (pixel, depth) = (y * size[0] + x, at(depths, s, t));
        if screen.shows(pixel, depth) {
            let mut colour = Vec4::ZERO;
            for (Source { texture, share, .. }, [xs, ys]) in sources.iter().zip(&own).take(len) {
                colour += texture.colour([at(*xs, s, t), at(*ys, s, t)]) * *share;
            }
            screen.put(pixel, depth, colour, covered);
        }
    });
}

/// Returns of each source where the corners are in it, x and y apart, and how many sources there are.
fn prepared<const N: usize>(
    corners: &[Corner; N],
    sources: &[Source<'_>],
) -> ([[[f32; N]; 2]; SOURCES], usize) {
    let mut out = [[[0.0; N]; 2]; SOURCES];
    for (out, source) in out.iter_mut().zip(sources) {
        let texel = |corner: Corner| source.texels.get(corner.number).copied().unwrap_or_default();
        *out = [corners.map(|corner| texel(corner)[0]), corners.map(|corner| texel(corner)[1])];
    }
    (out, sources.len().min(SOURCES))
}

fn clockwise_quad(
    screen: &mut Screen<'_>,
    corners: [Corner; 4],
    ring: [Step; 4],
    sources: &[Source<'_>],
) {
    let [p, q, r, s] = ring;
    // How far the ring is from a parallelogram: e x g and g x f, of e = q - p, f = s - p, g = r - q - f.
    let e_g = area(p, q, r) - area(p, q, s);
    let g_f = area(p, r, s) - area(p, q, s);
    let size = screen.size();
    let mut batch = Batch::default();
    let (own, sources_len) = prepared(&corners, sources);
    let depths = corners.map(|corner| corner.depth);
    let soft = corners.map(|corner| corner.soft);
    let bends = [e_g, g_f].map(|bend| bend as f32);
    let mut flush = |batch: &Batch, len: usize| {
        let shares = batch.shares(bends);
        let mut colours = [Vec4::ZERO; BATCH];
        for (Source { texture, share, .. }, axes) in sources.iter().zip(&own).take(sources_len) {
            let [x, y] = axes.map(|numbers| bilinear(numbers, shares));
            let places = Eight::floats(&x).iter().zip(Eight::floats(&y));
            for (colour, (x, y)) in colours.iter_mut().zip(places).take(len) {
                *colour += texture.colour([*x, *y]) * *share;
            }
        }
        let depths = bilinear(depths, shares);
        let pixels = batch.pixels.iter().zip(&batch.covered).zip(Eight::floats(&depths));
        for (((at, covered), depth), colour) in pixels.zip(colours).take(len) {
            if screen.shows(*at, *depth) {
                screen.put(*at, *depth, colour, *covered);
            }
        }
    };
    let mut len = 0;
    cover(&ring, soft, size, |[x, y], [above, beyond, below, before], covered| {
        let slopes = [beyond + before - e_g, below + above - g_f];
        // Outside along a border an edge function is negative, and the share that of the border.
        batch.set(len, (y * size[0] + x, covered), [before.max(0), above.max(0)], slopes);
        len += 1;
        if len == BATCH {
            flush(&batch, len);
            len = 0;
        }
    });
    flush(&batch, len);
}

/// Pixels of a quad whose places in it are computed together.
const BATCH: usize = 8;

/// Pixels of a quad: of each, across and down, the edge function at the way's beginning, and the slope of [`share`].
#[derive(Default)]
struct Batch {
    pixels: [usize; BATCH],
    covered: [f32; BATCH],
    before: [[f32; BATCH]; 2],
    slopes: [[f32; BATCH]; 2],
}

impl Batch {
    #[inline(always)]
    fn set(&mut self, at: usize, pixel: (usize, f32), before: [i64; 2], slopes: [i64; 2]) {
        if let (Some(out), Some(covered)) = (self.pixels.get_mut(at), self.covered.get_mut(at)) {
            (*out, *covered) = pixel;
        }
        let rows = self.before.iter_mut().chain(&mut self.slopes);
        for (row, number) in rows.zip(before.into_iter().chain(slopes)) {
            if let Some(out) = row.get_mut(at) {
                *out = number as f32;
            }
        }
    }

    /// Returns the shares across and down.
    #[inline(always)]
    fn shares(&self, [across, down]: [f32; 2]) -> [Lanes; 2] {
        let [left, top] = self.before.each_ref().map(lanes);
        let [own, other] = self.slopes.each_ref().map(lanes);
        [
            by_lane(left, own, |before, slope| share(before, slope, across)),
            by_lane(top, other, |before, slope| share(before, slope, down)),
        ]
    }
}

/// Returns what is bilinear in a quad of its four corners' numbers.
#[inline(always)]
fn bilinear([a, b, c, d]: [f32; 4], [s, t]: [Lanes; 2]) -> Lanes {
    by_lane(s, t, |s, t| {
        let (top, bottom) = (s * (b - a) + a, s * (c - d) + d);
        top + (bottom - top) * t
    })
}

#[inline(always)]
fn lanes(x: &[f32; BATCH]) -> Lanes {
    Lanes::read(&x.map(f32::to_le_bytes))
}

/// Does the same to each pair.
#[inline(always)]
fn by_lane<R: Real, const N: usize>(mut a: [R; N], b: [R; N], f: impl Fn(R, R) -> R) -> [R; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, b);
    }
    a
}

/// Returns a colour over another, rounded.
#[inline(always)]
pub(super) fn over(colour: Colour, below: [u8; 4]) -> [u8; 4] {
    let [r, g, b, a] = below;
    let below = Vec4::new(r.into(), g.into(), b.into(), a.into());
    rounded(colour * (1.0 / 255.0) + below * (1.0 - colour.w * (1.0 / ALPHA_MAX)))
}

/// Returns a colour over another of the same layer, on a share of the pixel, rounded: alpha becomes the greater one, so
/// that to lie on itself changes nothing.
#[inline(always)]
fn joined(colour: Colour, covered: f32, below: [u8; 4]) -> [u8; 4] {
    let own = colour * (1.0 / 255.0);
    let below = Vec4::from(below.map(f32::from));
    let both = own + below * (1.0 - own.w * (1.0 / 255.0));
    let scale = if both.w > 0.0 { greater(own.w, below.w) / both.w } else { 0.0 };
    rounded(below + (both * scale - below) * covered)
}

/// Rounds numbers in [0, 255]; what is greater becomes 255.
#[inline(always)]
fn rounded(colour: Colour) -> [u8; 4] {
    // The last bits of 1.5 2^23 and a whole number are those of the number.
    let [r, g, b, a] = (colour.min(Vec4::splat(255.0)) + ROUND).to_array();
    [r.to_bits() as u8, g.to_bits() as u8, b.to_bits() as u8, a.to_bits() as u8]
}

/// Returns twice the area of a triangle in its first source, positive where it turns clockwise.
fn turn(corners: [Corner; 3], sources: &[Source<'_>]) -> f32 {
    let texels = sources.first().map(|source| source.texels).unwrap_or_default();
    let [[ax, ay], [bx, by], [cx, cy]] =
        corners.map(|corner| texels.get(corner.number).copied().unwrap_or_default());
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Whether two areas turn against each other; one that is 0 turns either way.
fn flips(steps: i64, other: f32) -> bool {
    steps > 0 && other < 0.0 || steps < 0 && other > 0.0
}

/// Returns the share in [0, 1] of a way across a convex quad that a pixel has gone, of the edge functions at the quad's two
/// ends of that way, neither negative, of which `slope` is the sum less `bend`.
///
/// The share x solves `bend x² + slope x - before = 0`, which is negative at 0 and positive at 1: of the two roots the one
/// at which it rises. Each form keeps its last places where the other would lose them; neither divides by what is
/// negative.
#[inline(always)]
fn share<R: Real>(before: R, slope: R, bend: f32) -> R {
    let zero = R::from(0.0);
    let square = slope * slope + before * (4.0 * bend);
    let height = sqrt(greater(square, zero));
    let above = slope.where_less(zero, || height - slope, || before * 2.0);
    let below = slope.where_less(zero, || R::from(2.0 * bend), || slope + height);
    let share = zero.where_less(below, || above / below, || zero);
    lesser(greater(share, zero), R::from(1.0))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    const BLACK: [u8; 4] = [0, 0, 0, 255];

    /// Corners of an element without borders.
    fn corners<const N: usize>(places: [[f32; 2]; N], depth: f32) -> [Corner; N] {
        let corner = |number| Corner { place: places[number], depth, number, soft: 0.0 };
        core::array::from_fn(corner)
    }

    /// The same, all of whose edges are borders.
    fn bordered<const N: usize>(places: [[f32; 2]; N]) -> [Corner; N] {
        corners(places, 0.0).map(|corner| Corner { soft: 1.0, ..corner })
    }

    /// The whole of a texture, in which corners lie at these places.
    fn source<'a, const N: usize>(texture: Texture<'a>, places: [[f32; 2]; N]) -> [Source<'a>; 1] {
        let mut texels = [[0.0; 2]; 4];
        texels[..N].copy_from_slice(&places);
        [Source { texture, texels, share: 1.0 }]
    }

    /// One colour, in which corners lie as on the screen.
    fn plain<const N: usize>(texel: &[[u8; 4]; 1], places: [[f32; 2]; N]) -> [Source<'_>; 1] {
        source(Texture { width: 1, height: 1, texels: texel }, places)
    }

    fn blended(width: usize, pixels: &mut [[u8; 4]]) -> Screen<'_> {
        Screen { width, pixels, depths: None, opacity: 1.0, is_group: false }
    }

    fn random(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 40) as f32 / (1u64 << 24) as f32
    }

    #[test]
    fn where_it_is_in_its_texture_an_element_shows_it() {
        let (n, mut seed) = (128usize, 5);
        let texels: Vec<[u8; 4]> = (0..n * n)
            .map(|_| [0; 3].map(|_| 255 * u8::from(random(&mut seed) < 0.5)))
            .map(|[r, g, b]| [r, g, b, 255])
            .collect();
        let texture = Texture { width: n, height: n, texels: &texels };
        let cells = 9;
        let cell = n as f32 / cells as f32;
        let place = |x: usize, y: usize| {
            let mut seed = (x * 31 + y) as u64;
            [x, y].map(|i| {
                let inner = if i == 0 || i == cells { 0.0 } else { 0.5 };
                cell * (i as f32 + inner * (random(&mut seed) - 0.5))
            })
        };
        let mut pixels = vec![[9; 4]; n * n];
        let mut screen = blended(n, &mut pixels);
        for (y, x) in (0..cells).flat_map(|y| (0..cells).map(move |x| (y, x))) {
            let ring = [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
            let [a, b, c, d] = corners(ring, 0.0);
            let own = source(texture, ring);
            let screen = &mut screen;
            let flipped = match (x + y) % 3 {
                0 => quad(screen, [a, b, c, d], &own),
                1 => triangle(screen, [a, b, c], &own) | triangle(screen, [c, d, a], &own),
                _ => triangle(screen, [b, a, d], &own) | triangle(screen, [d, c, b], &own),
            };
            assert!(!flipped);
        }
        let apart = pixels.iter().zip(&texels).flat_map(|(a, b)| a.iter().zip(b));
        let worst = apart.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{worst:?}");
    }

    /// Inverts the bilinear map of a quad by Newton steps.
    fn inverted(ring: [[f64; 2]; 4], p: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = ring;
        let (mut s, mut t) = (0.5, 0.5);
        for _ in 0..60 {
            let at = |i: usize| {
                (1.0 - t) * (a[i] + (b[i] - a[i]) * s) + t * (d[i] + (c[i] - d[i]) * s) - p[i]
            };
            let by_s = |i: usize| (1.0 - t) * (b[i] - a[i]) + t * (c[i] - d[i]);
            let by_t = |i: usize| (1.0 - s) * (d[i] - a[i]) + s * (c[i] - b[i]);
            let (x, y) = (at(0), at(1));
            let det = by_s(0) * by_t(1) - by_s(1) * by_t(0);
            let (ds, dt) = ((x * by_t(1) - y * by_t(0)) / det, (by_s(0) * y - by_s(1) * x) / det);
            (s, t) = (s - ds, t - dt);
        }
        assert!([s, t].iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)), "{s} {t}");
        [s, t]
    }

    #[test]
    fn quads_are_inverted_as_in_double_precision() {
        // Texels of a slope in each direction.
        let n = 256;
        let texels: Vec<_> = (0..n * n).map(|i| [(i % n) as u8, (i / n) as u8, 7, 255]).collect();
        let texture = Texture { width: n, height: n, texels: &texels };
        let (size, mut seed, mut seen) = (96, 8, 0);
        for round in 0..40 {
            let mut ring =
                [[20.0f32, 20.0], [76.0, 20.0], [76.0, 76.0], [20.0, 76.0]].map(|corner| {
                    let moved = 30.0 * (1.0 - 1.0 / (1 + round) as f32);
                    corner
                        .map(|x| ((x + moved * (random(&mut seed) - 0.5)) * 256.0).round() / 256.0)
                });
            if round % 2 == 1 {
                ring.reverse();
            }
            let ends = [[0.5, 0.5], [255.5, 0.5], [255.5, 255.5], [0.5, 255.5]];
            let mut pixels = vec![[0; 4]; size * size];
            let mut screen = blended(size, &mut pixels);
            let flipped = quad(&mut screen, corners(ring, 0.0), &source(texture, ends));
            assert_eq!(flipped, round % 2 == 1);
            for (at, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0) {
                let p = [at % size, at / size].map(|x| x as f64 + 0.5);
                let share = inverted(ring.map(|place| place.map(f64::from)), p);
                let expected = share.map(|share| 255.0 * share);
                for (found, expected) in pixel.iter().zip(expected) {
                    assert!((f64::from(*found) - expected).abs() <= 0.51, "{found} {expected}");
                }
                seen += 1;
            }
        }
        assert!(seen > 100_000);
    }

    #[test]
    fn a_quad_that_is_not_convex_is_covered_once_and_told() {
        let half = [[0, 0, 0, 128]];
        for first in 0..4 {
            // The corner at 24, 24 points inwards.
            let mut ring = [[8.0, 8.0], [56.0, 8.0], [24.0, 24.0], [8.0, 56.0]];
            ring.rotate_left(first);
            let mut pixels = vec![[0; 4]; 64 * 64];
            let mut screen = blended(64, &mut pixels);
            assert!(quad(&mut screen, corners(ring, 0.0), &plain(&half, ring)));
            let area = pixels.iter().filter(|pixel| pixel[3] == 128).count();
            assert!((700..=840).contains(&area), "{area}");
            assert!(pixels.iter().all(|pixel| pixel[3] == 0 || pixel[3] == 128));
        }
    }

    #[test]
    fn what_turns_against_its_texture_is_told_and_drawn() {
        let ring = [[1.0, 1.0], [7.0, 1.0], [1.0, 7.0]];
        let [a, b, c] = ring;
        let red = [[255, 0, 0, 255]];
        for (texels, expected) in [([a, b, c], false), ([a, c, b], true)] {
            let mut pixels = vec![BLACK; 64];
            let mut screen = blended(8, &mut pixels);
            let own = plain(&red, texels);
            assert_eq!(triangle(&mut screen, corners(ring, 0.0), &own), expected);
            // The first source is the one that counts most.
            let both = [own, plain(&red, [a, c, b])].concat();
            assert_eq!(triangle(&mut screen, corners(ring, 0.0), &both), expected);
            assert_eq!(pixels.iter().filter(|pixel| pixel[0] == 255).count(), 15);
        }
        let flat = [a, b, [4.0, 1.0]];
        for corners in [corners(flat, 0.0), bordered(flat)] {
            let mut pixels = vec![BLACK; 64];
            assert!(!triangle(&mut blended(8, &mut pixels), corners, &plain(&red, flat)));
            assert!(pixels.iter().all(|pixel| *pixel == BLACK));
        }
    }

    const SQUARE: [[f32; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];

    #[test]
    fn without_depths_elements_are_blended() {
        let mut pixels = vec![[100, 200, 40, 255]; 16];
        let own = plain(&[[200, 100, 0, 51]], SQUARE);
        quad(&mut blended(4, &mut pixels), corners(SQUARE, 0.0), &own);
        // A fifth of the one and four of the other.
        assert_eq!(pixels, [[120, 180, 32, 255]; 16]);
    }

    #[test]
    fn sources_are_mixed_by_their_shares() {
        // Alike in triangles and quads; times their alpha: of the second a half.
        let [[first], [second]] = [&[[200, 100, 0, 255]], &[[40, 200, 80, 102]]]
            .map(|texel: &[[u8; 4]; 1]| plain(texel, SQUARE));
        for (shares, expected) in [
            ([1.0, 0.0], [200, 100, 0, 255]),
            ([0.75, 0.25], [154, 95, 8, 217]),
            ([0.25, 0.75], [62, 85, 24, 140]),
        ] {
            let sources =
                [Source { share: shares[0], ..first }, Source { share: shares[1], ..second }];
            let [a, b, c, d] = corners(SQUARE, 0.0);
            let mut pixels = vec![[0; 4]; 16];
            quad(&mut blended(4, &mut pixels), [a, b, c, d], &sources);
            assert_eq!(pixels, [expected; 16]);
            let mut pixels = vec![[0; 4]; 16];
            triangle(&mut blended(4, &mut pixels), [a, b, c], &sources);
            triangle(&mut blended(4, &mut pixels), [a, c, d], &sources);
            assert_eq!(pixels, [expected; 16]);
        }
    }

    #[test]
    fn each_source_has_its_own_corners() {
        // Of a slope each, across and down.
        let n = 16;
        let texels: Vec<_> =
            (0..n * n).map(|i| [16 * (i % n) as u8, 16 * (i / n) as u8, 0, 255]).collect();
        let texture = Texture { width: n, height: n, texels: &texels };
        let size = n as f32;
        let ring = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
        // The second one lies in it a quarter turned.
        let turned = [ring[1], ring[2], ring[3], ring[0]];
        let [[first], [second]] = [ring, turned].map(|places| source(texture, places));
        let sources = [Source { share: 0.75, ..first }, Source { share: 0.25, ..second }];
        let mut pixels = vec![[0; 4]; n * n];
        quad(&mut blended(n, &mut pixels), corners(ring, 0.0), &sources);
        for (at, [r, g, ..]) in pixels.iter().enumerate() {
            let [x, y] = [at % n, at / n].map(|x| x as f32);
            let expected = [12.0 * x + 4.0 * (15.0 - y), 12.0 * y + 4.0 * x];
            for (found, expected) in [*r, *g].into_iter().zip(expected) {
                assert!((f32::from(found) - expected).abs() <= 0.51, "{at} {found} {expected}");
            }
        }
    }

    #[test]
    fn borders_are_soft_and_edges_within_are_not() {
        // A square from 2.25 to 9.25, cut along either diagonal or whole; of either direction.
        let (low, high) = (2.25, 9.25);
        let mut ring = [[low, low], [high, low], [high, high], [low, high]];
        let covered = |i: usize| match i {
            0 | 1 | 10.. => 0.0,
            // A quarter of its width is outside, or inside: from the border to the centre.
            2 => 0.75,
            9 => 0.25,
            _ => 1.0,
        };
        let white = [[255; 4]];
        let inner = |corner: Corner| Corner { soft: 0.0, ..corner };
        for round in 0..8 {
            ring.rotate_left(1);
            if round == 4 {
                ring.reverse();
            }
            let own = plain(&white, ring);
            let [a, b, c, d] = bordered(ring);
            let [mut cut, mut whole] = [(); 2].map(|()| vec![[0; 4]; 144]);
            let screen = &mut blended(12, &mut cut);
            triangle(screen, [a, b, inner(c)], &own);
            triangle(screen, [inner(a), c, d], &own);
            quad(&mut blended(12, &mut whole), [a, b, c, d], &own);
            for (at, (cut, whole)) in cut.iter().zip(&whole).enumerate() {
                let expected = 255.0 * covered(at % 12) * covered(at / 12);
                // At either end of the cut a pixel has the border of one triangle alone.
                let is_corner = [at % 12, at / 12].iter().all(|i| matches!(i, 2 | 9));
                let most = if is_corner { 64.0 } else { 0.51 };
                for (found, most) in [(cut, most), (whole, 0.51)] {
                    let apart = (f32::from(found[3]) - expected).abs();
                    assert!(apart <= most, "{at}: {found:?} {expected}");
                }
                assert!(cut.iter().all(|x| *x == cut[3]) && whole.iter().all(|x| *x == whole[3]));
            }
            // Of an edge within that were soft, too, a slit would be seen.
            let mut slit = vec![[0; 4]; 144];
            let screen = &mut blended(12, &mut slit);
            triangle(screen, [a, b, c], &own);
            triangle(screen, [a, c, d], &own);
            assert!((3..9).any(|i| slit
                [if ring[0][0] == ring[0][1] { 13 * i } else { 11 * (i + 1) }][3]
                < 250));
        }
    }

    #[test]
    fn a_quad_that_is_cut_in_two_has_no_border_within() {
        let white = [[255; 4]];
        for first in 0..4 {
            let mut ring = [[8.0, 8.0], [56.0, 8.0], [24.0, 24.0], [8.0, 56.0]];
            ring.rotate_left(first);
            let mut pixels = vec![[0; 4]; 64 * 64];
            assert!(quad(&mut blended(64, &mut pixels), bordered(ring), &plain(&white, ring)));
            // The cut goes from 8, 8 to 24, 24.
            assert!((9..23).all(|i| pixels[65 * i] == [255; 4]), "{first}");
            let sum: f32 = pixels.iter().map(|pixel| f32::from(pixel[3]) / 255.0).sum();
            assert!((sum - 768.0).abs() < 2.0, "{sum}");
        }
    }

    #[test]
    fn with_depths_the_nearer_wins_then_the_first() {
        // The last is nearest, and so thin that it hides nothing.
        let colours = [[10, 0, 0, 255], [20, 0, 0, 255], [30, 0, 0, 255], [40, 0, 0, 127]];
        for (order, expected) in [([0, 1, 2, 3], 25), ([1, 0, 3, 2], 30), ([2, 3, 1, 0], 20)] {
            let depths = [5.0, 5.0, 6.0, 1.0];
            let (mut pixels, mut nearest) = (vec![BLACK; 16], vec![f32::INFINITY; 16]);
            for element in order {
                let depths_of = Some(&mut *nearest);
                let mut screen = Screen { depths: depths_of, ..blended(4, &mut pixels) };
                let own = [colours[element]];
                quad(&mut screen, corners(SQUARE, depths[element]), &plain(&own, SQUARE));
            }
            assert_eq!(pixels, [[expected, 0, 0, 255]; 16]);
            assert_eq!(nearest, [5.0; 16]);
        }
    }

    #[test]
    fn from_half_of_alpha_on_a_pixel_hides() {
        for (alpha, hides) in [(127, false), (128, true)] {
            for has_quads in [false, true] {
                let (mut pixels, mut nearest) = (vec![[0; 4]; 16], vec![f32::INFINITY; 16]);
                let depths = Some(&mut *nearest);
                let mut screen = Screen { depths, ..blended(4, &mut pixels) };
                for (depth, texel) in [(1.0, [[0, 0, 0, alpha]]), (2.0, [[255; 4]])] {
                    let own = plain(&texel, SQUARE);
                    let [a, b, c, d] = corners(SQUARE, depth);
                    if has_quads {
                        quad(&mut screen, [a, b, c, d], &own);
                    } else {
                        triangle(&mut screen, [a, b, c], &own);
                        triangle(&mut screen, [a, c, d], &own);
                    }
                }
                assert!(pixels.iter().all(|pixel| (pixel[0] == 0) == hides), "{alpha}");
            }
        }
    }

    #[test]
    fn depths_lie_on_the_plane_of_their_corners() {
        let place = [[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]];
        let plane = |[x, y]: [f32; 2]| 3.0 + 0.5 * x - 0.25 * y;
        let slanted =
            corners(place, 0.0).map(|corner| Corner { depth: plane(corner.place), ..corner });
        let (mut pixels, mut nearest) = (vec![BLACK; 64], vec![f32::INFINITY; 64]);
        let depths = Some(&mut *nearest);
        let mut screen = Screen { depths, ..blended(8, &mut pixels) };
        triangle(&mut screen, slanted, &plain(&[[1, 2, 3, 255]], place));
        let mut seen = 0;
        for (at, depth) in nearest.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
            let centre = [at % 8, at / 8].map(|x| x as f32 + 0.5);
            assert!((depth - plane(centre)).abs() < 1e-5);
            seen += 1;
        }
        assert!(seen >= 28, "{seen}");
    }
}
