//! Elements onto a screen: textures mapped and blended, by depth or by order (METHOD §6.9).

use super::blend::SOURCES;
use super::cover::{Step, area, cover, snap};
use super::sample::{ALPHA_MAX, Colour};
use super::view::Texture;
use crate::lanes::{Eight, Lanes, ROUND, Real};
use crate::numeric::{greater, lesser, sqrt};
use glam::Vec4;

#[cfg(test)]
mod tests;

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
        if colour.w == 0.0 {
            return;
        }
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

/// Blends a layer over a picture.
///
/// - `clip`: how far each pixel of the layer is seen, in 255ths.
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

/// Leaves of a clip what a layer covers.
pub(super) fn multiply_mask(layer: &[[u8; 4]], opacity: f32, clip: &mut [u8]) {
    let scale = opacity / ALPHA_MAX * 255.0;
    for ([.., alpha], out) in layer.iter().zip(clip) {
        *out = (f32::from(*out) * f32::from(*alpha) * scale + 0.5) as u8;
    }
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
    let form = Form {
        ring,
        edges: |[towards_c, _, towards_b]: [i64; 3]| [towards_b, towards_c],
        shares: |edges: [Lanes; 2]| edges.map(|edge| edge.map(|edge| edge * share)),
        at: |[a, b, c]: [f32; 3], [s, t]: [Lanes; 2]| {
            by_lane(s, t, |s, t| s * (b - a) + t * (c - a) + a)
        },
    };
    fill(screen, corners, sources, &form);
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
    let form = Form {
        ring,
        edges: |[above, beyond, below, before]: [i64; 4]| {
            [before, above, beyond + before - e_g, below + above - g_f]
        },
        shares: |[left, top, across, down]: [Lanes; 4]| {
            [
                by_lane(left, across, |before, slope| share(before, slope, e_g as f32)),
                by_lane(top, down, |before, slope| share(before, slope, g_f as f32)),
            ]
        },
        at: |[a, b, c, d]: [f32; 4], [s, t]: [Lanes; 2]| {
            by_lane(s, t, |s, t| {
                let (top, bottom) = (s * (b - a) + a, s * (c - d) + d);
                top + (bottom - top) * t
            })
        },
    };
    fill(screen, corners, sources, &form);
}

/// How numbers of N corners lie in an element on the screen.
struct Form<E, S, A, const N: usize> {
    /// The corners.
    ring: [Step; N],
    /// Of a pixel's edge functions M numbers.
    edges: E,
    /// Of M numbers its two shares in the element.
    shares: S,
    /// Of the corners' numbers that at two shares.
    at: A,
}

/// Draws the pixels that an element covers.
fn fill<const N: usize, const M: usize>(
    screen: &mut Screen<'_>,
    corners: [Corner; N],
    sources: &[Source<'_>],
    form: &Form<
        impl Fn([i64; N]) -> [i64; M],
        impl Fn([Lanes; M]) -> [Lanes; 2],
        impl Fn([f32; N], [Lanes; 2]) -> Lanes,
        N,
    >,
) {
    // Of each source where the corners are in it, x and y apart.
    let mut places = [[[0.0; N]; 2]; SOURCES];
    for (out, source) in places.iter_mut().zip(sources) {
        let texel = |corner: Corner| source.texels.get(corner.number).copied().unwrap_or_default();
        *out = [corners.map(|corner| texel(corner)[0]), corners.map(|corner| texel(corner)[1])];
    }
    let depths = corners.map(|corner| corner.depth);
    let size = screen.size();
    let mut flush = |batch: &Batch<M>| {
        let shares = (form.shares)(batch.edges.each_ref().map(lanes));
        let mut colours = [Vec4::ZERO; BATCH];
        for (Source { texture, share, .. }, axes) in sources.iter().zip(&places) {
            let place = axes.map(|numbers| (form.at)(numbers, shares));
            texture.add(place, *share, colours.iter_mut().take(batch.len));
        }
        let depths = (form.at)(depths, shares);
        let pixels = batch.pixels.iter().zip(Eight::floats(&depths)).zip(colours);
        for (((at, covered), depth), colour) in pixels.take(batch.len) {
            if screen.shows(*at, *depth) {
                screen.put(*at, *depth, colour, *covered);
            }
        }
    };
    let mut batch = Batch { len: 0, pixels: [(0, 0.0); BATCH], edges: [[0.0; BATCH]; M] };
    let soft = corners.map(|corner| corner.soft);
    cover(&form.ring, soft, size, |[x, y], edges, covered| {
        batch.add((y * size[0] + x, covered), (form.edges)(edges));
        if batch.len == BATCH {
            flush(&batch);
            batch.len = 0;
        }
    });
    flush(&batch);
}

/// Pixels whose places in an element are computed together.
const BATCH: usize = 8;

/// Pixels of an element: of each its number, the share that is covered, and what its edge functions make.
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
fn over(colour: Colour, below: [u8; 4]) -> [u8; 4] {
    let [r, g, b, a] = below;
    let below = Vec4::new(r.into(), g.into(), b.into(), a.into());
    rounded(colour * (1.0 / 255.0) + below * (1.0 - colour.w * (1.0 / ALPHA_MAX)))
}

/// Returns a colour over another of the same layer, on a share of the pixel, rounded: alpha becomes the greater one, so
/// that to lie on itself changes nothing.
#[inline(always)]
fn joined(colour: Colour, covered: f32, below: [u8; 4]) -> [u8; 4] {
    let own = colour * (1.0 / 255.0);
    // Most pixels are the first element's that touches them.
    if below == [0; 4] {
        return rounded(own * covered);
    }
    let below = Vec4::from(below.map(f32::from));
    let both = own + below * (1.0 - own.w * (1.0 / 255.0));
    let both = both * (greater(own.w, below.w) / both.w);
    rounded(below + (both - below) * covered)
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

/// Returns the share in [0, 1] of a way across a convex quad that a pixel has gone: 0 outside its beginning, where `before`
/// is negative. `before` is the edge function there, and `slope` the sum of those at both ends less `bend`.
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
