//! Drawing of elements on a screen: textures are mapped and blended, by depth or in order (METHOD
//! §6.9).

use super::blend::SOURCES_MAX;
use super::cover::{Step, area, cover, snap};
use super::sample::{ALPHA_MAX, Colour};
use super::view::Texture;
use crate::lanes::{Lanes, ROUND, Real, Unit, in_lanes};
use crate::numeric::{greater, lesser, sqrt};
use crate::unit::{by_unit, level};
use glam::Vec4;

#[cfg(test)]
mod tests;

/// A corner of an element.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// Place on the screen, in pixels, y down.
    pub(super) place: [f32; 2],
    /// Distance from the viewer.
    pub(super) depth: f32,
    /// Index among the element's corners.
    pub(super) number: usize,
    /// Width in pixels over which the edge to the next corner fades out: 1 for a border, 0 for an
    /// inner edge.
    pub(super) soft: f32,
}

/// Source of an element's colours: a texture, the corners' places in the texture, and the source's
/// share.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source<'a> {
    pub(super) texture: Texture<'a>,
    pub(super) texels: [[f32; 2]; 4],
    pub(super) share: f32,
}

/// A picture that elements are drawn over.
pub(super) struct Screen<'a> {
    pub(super) width: usize,
    /// RGBA8 pixels with premultiplied alpha, row by row from the top.
    pub(super) pixels: &'a mut [[u8; 4]],
    /// Distance of each pixel from the viewer. Without depths, elements are blended in order.
    pub(super) depths: Option<&'a mut [f32]>,
    /// Opacity of drawn elements, from 0 to 1.
    pub(super) opacity: f32,
    /// Whether the screen holds a single layer. In a single layer no pixel becomes more opaque than
    /// its most opaque element.
    pub(super) is_group: bool,
}

impl Screen<'_> {
    fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len().checked_div(self.width).unwrap_or(0)]
    }

    /// Whether an element at this depth is visible in a pixel.
    #[inline(always)]
    fn shows(&self, at: usize, depth: f32) -> bool {
        let is_nearest = |depths: &[f32]| depths.get(at).is_some_and(|nearest| depth < *nearest);
        self.depths.as_deref().is_none_or(is_nearest)
    }

    /// Draws a colour at a pixel and a depth, over a share of the pixel.
    #[inline(always)]
    fn put(&mut self, at: usize, depth: f32, colour: Colour, covered: f32) {
        if colour.w == 0.0 {
            return;
        }
        // A fading edge does not hide the elements behind it.
        if let Some(nearest) = self.depths.as_mut().and_then(|depths| depths.get_mut(at))
            && colour.w >= 0.5 * ALPHA_MAX
            && covered == 1.0
        {
            *nearest = depth;
        }
        if let Some(pixel) = self.pixels.get_mut(at) {
            *pixel = if self.is_group {
                over_in_group(colour, covered, *pixel)
            } else {
                over(colour * (self.opacity * covered), *pixel)
            };
        }
    }
}

/// Draws a triangle with an affine texture map. Returns whether the triangle is flipped against its
/// first source.
pub(super) fn triangle(
    screen: &mut Screen<'_>,
    corners: [Corner; 3],
    sources: &[Source<'_>],
) -> bool {
    let [a, b, c] = corners;
    let [p, q, r] = corners.map(|corner| snap(corner.place));
    let whole = area(p, q, r);
    let is_flipped = flips(whole, texture_area([a, b, c], sources));
    match whole {
        0 => {}
        1.. => clockwise_triangle(screen, [a, b, c], [p, q, r], sources),
        _ => clockwise_triangle(screen, reversed([a, b, c]), [p, r, q], sources),
    }
    is_flipped
}

/// Draws a quad. A convex quad has a bilinear texture map; another quad is drawn as two triangles.
/// Returns whether the quad is flipped against its first source, or folded.
pub(super) fn quad(screen: &mut Screen<'_>, corners: [Corner; 4], sources: &[Source<'_>]) -> bool {
    let [a, b, c, d] = corners;
    let ring = corners.map(|corner| snap(corner.place));
    let [p, q, r, s] = ring;
    let turns = [area(s, p, q), area(p, q, r), area(q, r, s), area(r, s, p)];
    let whole = turns.iter().sum::<i64>();
    let is_flipped =
        flips(whole, texture_area([a, b, c], sources) + texture_area([a, c, d], sources));
    // Reflex corners; a straight corner is not reflex.
    let reflex = turns.map(|turn| flips(turn, whole as f32));
    // The cut between the triangles is not a border.
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

/// Blends a layer over a picture.
///
/// - `clip`: coverage of each pixel by the clipping layers, in 255ths.
/// - `opacity`: from 0 to 1.
pub(super) fn blend_group(
    layer: &[[u8; 4]],
    clip: Option<&[u8]>,
    opacity: f32,
    out: &mut [[u8; 4]],
) {
    for (at, (own, out)) in layer.iter().zip(out).enumerate().filter(|(_, (own, _))| own[3] > 0) {
        let seen = clip.map_or(1.0, |clip| f32::from(clip.get(at).copied().unwrap_or(0)) / 255.0);
        let colour = Vec4::from(own.map(f32::from)) * 255.0;
        *out = over(colour * (opacity * seen), *out);
    }
}

/// Multiplies a clip by the coverage of a layer.
pub(super) fn multiply_mask(layer: &[[u8; 4]], opacity: f32, clip: &mut [u8]) {
    let scale = opacity / ALPHA_MAX * 255.0;
    for ([.., alpha], out) in layer.iter().zip(clip) {
        *out = (f32::from(*out) * f32::from(*alpha) * scale + 0.5) as u8;
    }
}

/// Reverses a ring, keeping its first corner. Each edge's softness moves to the corner that the
/// edge now starts from.
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
    fill(screen, (corners, ring), sources, &Triangle { share });
}

fn clockwise_quad(
    screen: &mut Screen<'_>,
    corners: [Corner; 4],
    ring: [Step; 4],
    sources: &[Source<'_>],
) {
    let [p, q, r, s] = ring;
    let e_g = area(p, q, r) - area(p, q, s);
    let g_f = area(p, r, s) - area(p, q, s);
    fill(screen, (corners, ring), sources, &Quad { e_g, g_f });
}

/// Interpolation of N corner values over an element on the screen.
trait Interpolation<const N: usize, const M: usize> {
    /// Computes M numbers from the edge functions of a pixel.
    fn edges(&self, edges: [i64; N]) -> [i64; M];

    /// Computes a pixel's two coordinates in the element from the M numbers.
    fn shares<U: Unit>(&self, numbers: [Lanes<U>; M]) -> [Lanes<U>; 2];

    /// Interpolates the corner values at two coordinates.
    fn at<U: Unit>(unit: U, values: [f32; N], shares: [Lanes<U>; 2]) -> Lanes<U>;
}

struct Triangle {
    /// The inverse of the area.
    share: f32,
}

impl Interpolation<3, 2> for Triangle {
    #[inline(always)]
    fn edges(&self, [towards_c, _, towards_b]: [i64; 3]) -> [i64; 2] {
        [towards_b, towards_c]
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn shares<U: Unit>(&self, [s, t]: [Lanes<U>; 2]) -> [Lanes<U>; 2] {
        [
            in_lanes(
                s,
                #[inline(always)]
                |edge| edge * self.share,
            ),
            in_lanes(
                t,
                #[inline(always)]
                |edge| edge * self.share,
            ),
        ]
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn at<U: Unit>(_: U, [a, b, c]: [f32; 3], [s, t]: [Lanes<U>; 2]) -> Lanes<U> {
        by_lane(
            s,
            t,
            #[inline(always)]
            |s, t| s * (b - a) + t * (c - a) + a,
        )
    }
}

/// The ring's deviation from a parallelogram: e x g and g x f, with e = q - p, f = s - p, g = r - q - f.
struct Quad {
    e_g: i64,
    g_f: i64,
}

impl Interpolation<4, 4> for Quad {
    #[inline(always)]
    fn edges(&self, [above, beyond, below, before]: [i64; 4]) -> [i64; 4] {
        [before, above, beyond + before - self.e_g, below + above - self.g_f]
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn shares<U: Unit>(&self, [left, top, across, down]: [Lanes<U>; 4]) -> [Lanes<U>; 2] {
        [
            by_lane(
                left,
                across,
                #[inline(always)]
                |before, slope| coordinate(before, slope, self.e_g as f32),
            ),
            by_lane(
                top,
                down,
                #[inline(always)]
                |before, slope| coordinate(before, slope, self.g_f as f32),
            ),
        ]
    }

    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn at<U: Unit>(_: U, [a, b, c, d]: [f32; 4], [s, t]: [Lanes<U>; 2]) -> Lanes<U> {
        by_lane(
            s,
            t,
            #[inline(always)]
            |s, t| {
                let (top, bottom) = (s * (b - a) + a, s * (c - d) + d);
                top + (bottom - top) * t
            },
        )
    }
}

/// Draws the pixels that an element covers.
fn fill<const N: usize, const M: usize, I: Interpolation<N, M>>(
    screen: &mut Screen<'_>,
    (corners, ring): ([Corner; N], [Step; N]),
    sources: &[Source<'_>],
    interpolation: &I,
) {
    // Corner places in each source, x and y separately.
    let mut places = [[[0.0; N]; 2]; SOURCES_MAX];
    for (out, source) in places.iter_mut().zip(sources) {
        let texel = |corner: Corner| source.texels.get(corner.number).copied().unwrap_or_default();
        *out = [corners.map(|corner| texel(corner)[0]), corners.map(|corner| texel(corner)[1])];
    }
    let depths = corners.map(|corner| corner.depth);
    let (size, level) = (screen.size(), level());
    let mut flush = |batch: &Batch<M>| {
        let mut colours = [Vec4::ZERO; BATCH];
        let own = colours.get_mut(..batch.len).unwrap_or_default();
        let depths = by_unit!(level, unit => {
            let shares = shares(unit, interpolation, &batch.edges);
            for (source, [x, y]) in sources.iter().zip(&places) {
                let place = [I::at(unit, *x, shares), I::at(unit, *y, shares)];
                source.texture.add(unit, place, source.share, own.iter_mut());
            }
            unit.floats(I::at(unit, depths, shares))
        });
        let pixels = batch.pixels.iter().zip(depths).zip(colours);
        for (((at, covered), depth), colour) in pixels.take(batch.len) {
            if screen.shows(*at, depth) {
                screen.put(*at, depth, colour, *covered);
            }
        }
    };
    let mut batch = Batch { len: 0, pixels: [(0, 0.0); BATCH], edges: [[0.0; BATCH]; M] };
    let soft = corners.map(|corner| corner.soft);
    cover(&ring, soft, size, |[x, y], edges, covered| {
        batch.add((y * size[0] + x, covered), interpolation.edges(edges));
        if batch.len == BATCH {
            flush(&batch);
            batch.len = 0;
        }
    });
    flush(&batch);
}

/// Computes the coordinates of pixels in their element.
#[cfg_attr(not(target_os = "none"), inline(always))]
fn shares<U: Unit, const N: usize, const M: usize>(
    unit: U,
    interpolation: &impl Interpolation<N, M>,
    edges: &[[f32; BATCH]; M],
) -> [Lanes<U>; 2] {
    let mut numbers = [unit.load(&[0.0; BATCH]); M];
    for (numbers, edges) in numbers.iter_mut().zip(edges) {
        *numbers = unit.load(edges);
    }
    interpolation.shares::<U>(numbers)
}

/// Pixels that are computed together.
const BATCH: usize = 8;

/// Pixels of an element: index, covered share, and the numbers from the edge functions.
struct Batch<const M: usize> {
    len: usize,
    pixels: [(usize, f32); BATCH],
    edges: [[f32; BATCH]; M],
}

impl<const M: usize> Batch<M> {
    #[inline(always)]
    fn add(&mut self, pixel: (usize, f32), edges: [i64; M]) {
        if let Some(out) = self.pixels.get_mut(self.len) {
            *out = pixel;
        }
        for (row, number) in self.edges.iter_mut().zip(edges) {
            if let Some(out) = row.get_mut(self.len) {
                *out = number as f32;
            }
        }
        self.len += 1;
    }
}

/// Applies a function to each pair of lanes.
#[inline(always)]
fn by_lane<R: Real, const N: usize>(mut a: [R; N], b: [R; N], f: impl Fn(R, R) -> R) -> [R; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = f(*a, b);
    }
    a
}

/// Blends a colour over another, and rounds.
#[inline(always)]
fn over(colour: Colour, below: [u8; 4]) -> [u8; 4] {
    let [r, g, b, a] = below;
    let below = Vec4::new(r.into(), g.into(), b.into(), a.into());
    rounded(colour * (1.0 / 255.0) + below * (1.0 - colour.w * (1.0 / ALPHA_MAX)))
}

/// Blends a colour over another of the same layer, over a share of the pixel, and rounds. Alpha
/// becomes the greater of both, so that overlap in a layer changes nothing.
#[inline(always)]
fn over_in_group(colour: Colour, covered: f32, below: [u8; 4]) -> [u8; 4] {
    let own = colour * (1.0 / 255.0);
    // Most pixels are touched by a single element.
    if below == [0; 4] {
        return rounded(own * covered);
    }
    let below = Vec4::from(below.map(f32::from));
    let both = own + below * (1.0 - own.w * (1.0 / 255.0));
    let both = both * (greater(own.w, below.w) / both.w);
    rounded(below + (both - below) * covered)
}

/// Rounds numbers in [0, 255]; greater numbers become 255.
#[inline(always)]
fn rounded(colour: Colour) -> [u8; 4] {
    // Adding 1.5 2^23 puts the whole number into the last bits.
    let [r, g, b, a] = (colour.min(Vec4::splat(255.0)) + ROUND).to_array();
    [r.to_bits() as u8, g.to_bits() as u8, b.to_bits() as u8, a.to_bits() as u8]
}

/// Returns twice the signed area of a triangle in its first source, positive for a clockwise
/// triangle.
fn texture_area(corners: [Corner; 3], sources: &[Source<'_>]) -> f32 {
    let texels = sources.first().map(|source| source.texels).unwrap_or_default();
    let [[ax, ay], [bx, by], [cx, cy]] =
        corners.map(|corner| texels.get(corner.number).copied().unwrap_or_default());
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Whether two signed areas have opposite signs; an area of 0 has either sign.
fn flips(steps: i64, other: f32) -> bool {
    steps > 0 && other < 0.0 || steps < 0 && other > 0.0
}

/// Returns a pixel's coordinate across a convex quad, in [0, 1]. `before` is the edge function at
/// the start; a negative value gives 0. `slope` is the sum of the edge functions at both ends, less
/// `bend`.
///
/// The coordinate x solves `bend x² + slope x - before = 0`. The polynomial is negative at 0 and
/// positive at 1, so x is the root with positive slope. Of the two closed forms, each is used where
/// the other would cancel, and neither divides by a negative number.
#[inline(always)]
fn coordinate<R: Real>(before: R, slope: R, bend: f32) -> R {
    let zero = slope.splat(0.0);
    let square = slope * slope + before * (4.0 * bend);
    let height = sqrt(greater(square, zero));
    let above = slope.where_less(zero, || height - slope, || before * 2.0);
    let below = slope.where_less(zero, || slope.splat(2.0 * bend), || slope + height);
    let share = zero.where_less(below, || above / below, || zero);
    lesser(greater(share, zero), share.splat(1.0))
}
