//! Textures, and their colours between texels.

use crate::numeric::{greater, lesser};
use glam::Vec4;

/// A picture of RGBA8 texels, sRGB, straight alpha, row by row from the top.
#[derive(Clone, Copy, Debug, Default)]
pub struct Texture<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: &'a [[u8; 4]],
}

/// A colour times its alpha, and that alpha times the most of it, in [0, [`ALPHA_MAX`]] and as sRGB encodes it: the numbers of
/// a file are neither decoded nor encoded again.
pub(super) type Colour = Vec4;

/// 255²: a byte times the greatest alpha.
pub(super) const ALPHA_MAX: f32 = 65_025.0;

impl<'a> Texture<'a> {
    /// Returns width and height in texels.
    pub const fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Returns its texels.
    pub const fn texels(&self) -> &'a [[u8; 4]] {
        self.texels
    }

    /// Returns the colour at a place in texels, whose centres are at 0.5, between the four nearest; beyond the centres
    /// of the outermost, theirs.
    #[inline]
    pub(super) fn colour(&self, [x, y]: [f32; 2]) -> Colour {
        let Self { width, height, .. } = *self;
        let ((x0, x1, across), (y0, y1, down)) = (between(x, width), between(y, height));
        let texel = |at: usize| self.texels.get(at).copied().unwrap_or_default();
        let (first, row) = (y0 * width, (y1 - y0) * width);
        let [left, right] = [first + x0, first + x1];
        let [a, b, c, d] = [texel(left), texel(right), texel(left + row), texel(right + row)];
        // Much of a drawing is empty, or of one colour.
        if a[3] | b[3] | c[3] | d[3] == 0 {
            return Vec4::ZERO;
        }
        if a == b && c == d && a == c {
            return weighed(a);
        }
        let [a, b, c, d] = [a, b, c, d].map(weighed);
        mixed(mixed(a, b, across), mixed(c, d, across), down)
    }
}

/// Multiplies a texel by its alpha.
#[inline(always)]
fn weighed([r, g, b, a]: [u8; 4]) -> Colour {
    Vec4::new(r.into(), g.into(), b.into(), 255.0) * f32::from(a)
}

/// Returns the two texels of `len` beside a coordinate, and its way from the first to the second.
#[inline(always)]
fn between(x: f32, len: usize) -> (usize, usize, f32) {
    let last = len.saturating_sub(1);
    let kept = lesser(last as f32, greater(0.0, x - 0.5));
    // Below 2^16, as many as a file has, a shorter cast does.
    let first = kept as i32;
    let at = first as usize;
    (at, (at + 1).min(last), kept - first as f32)
}

#[inline(always)]
fn mixed(a: Colour, b: Colour, share: f32) -> Colour {
    a + (b - a) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXELS: [[u8; 4]; 6] = [
        [255, 0, 0, 255],
        [0, 255, 0, 255],
        [0, 0, 255, 0],
        [10, 20, 30, 255],
        [40, 50, 60, 255],
        [200, 100, 50, 51],
    ];
    const TEXTURE: Texture<'_> = Texture { width: 3, height: 2, texels: &TEXELS };

    fn colour(place: [f32; 2]) -> [f32; 4] {
        (TEXTURE.colour(place) / 255.0).to_array()
    }

    #[test]
    fn centres_give_their_texel_times_its_alpha() {
        assert_eq!(TEXTURE.size(), [3, 2]);
        assert_eq!(colour([0.5, 0.5]), [255.0, 0.0, 0.0, 255.0]);
        assert_eq!(colour([1.5, 1.5]), [40.0, 50.0, 60.0, 255.0]);
        assert_eq!(colour([2.5, 1.5]), [40.0, 20.0, 10.0, 51.0]);
        // Nothing is seen of a colour without alpha.
        assert_eq!(colour([2.5, 0.5]), [0.0; 4]);
    }

    #[test]
    fn between_centres_colours_are_weighed_and_beyond_them_kept() {
        assert_eq!(colour([1.25, 0.5]), [63.75, 191.25, 0.0, 255.0]);
        // A quarter of each of the first four.
        assert_eq!(colour([1.0, 1.0]), [76.25, 81.25, 22.5, 255.0]);
        assert_eq!(colour([-7.0, -1e30]), colour([0.5, 0.5]));
        assert_eq!(colour([1e30, 9.0]), colour([2.5, 1.5]));
        assert!(colour([f32::NAN, f32::INFINITY]).iter().all(|x| x.is_finite()));
        assert_eq!(Texture { width: 0, height: 0, texels: &[] }.colour([0.0, 0.0]), Vec4::ZERO);
    }
}
