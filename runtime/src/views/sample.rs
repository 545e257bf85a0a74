//! Sampling of textures between texels.

use super::view::Texture;
use crate::lanes::{Lanes, ROUND, Real, Unit};
use crate::numeric::{greater, lesser};
use glam::Vec4;

/// A premultiplied colour: each channel times its alpha, and alpha times 255, all in [0,
/// [`ALPHA_MAX`]] and in sRGB encoding. Texels are neither decoded nor encoded.
pub(super) type Colour = Vec4;

/// 255²: a byte times the greatest alpha.
pub(super) const ALPHA_MAX: f32 = 65_025.0;

impl Texture<'_> {
    /// Adds a share of the bilinearly sampled colours at places in texels. Texel centres are at
    /// 0.5. Places outside the outermost centres take the outermost colours.
    ///
    /// - `out`: one colour per place, or fewer.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(super) fn add<'o, U: Unit>(
        &self,
        unit: U,
        [x, y]: [Lanes<U>; 2],
        share: f32,
        out: impl Iterator<Item = &'o mut Colour>,
    ) {
        let [columns, rows] = [locate(unit, x, self.width), locate(unit, y, self.height)];
        let places = columns.each().zip(rows.each());
        for (((column, across), (row, down)), out) in places.zip(out) {
            let at = row * self.width + column;
            let texel = |at: usize| self.texels.get(at).copied().unwrap_or_default();
            let below = at + self.width;
            let [a, b, c, d] = [texel(at), texel(at + 1), texel(below), texel(below + 1)];
            // Large parts of a drawing are empty, or of one colour.
            if a[3] | b[3] | c[3] | d[3] == 0 {
                continue;
            }
            *out += share
                * if a == b && c == d && a == c {
                    premultiplied(a)
                } else {
                    let [a, b, c, d] = [a, b, c, d].map(premultiplied);
                    lerp(lerp(a, b, across), lerp(c, d, across), down)
                };
        }
    }
}

/// Premultiplies a texel by its alpha.
#[inline(always)]
fn premultiplied([r, g, b, a]: [u8; 4]) -> Colour {
    Vec4::new(r.into(), g.into(), b.into(), 255.0) * f32::from(a)
}

/// The first of two neighbouring texels, and the fraction of the way to the second.
struct Neighbours {
    first: [f32; 8],
    fraction: [f32; 8],
}

impl Neighbours {
    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = (usize, f32)> {
        // The last bits of 1.5 2^23 plus a whole number are the number. Files have fewer than 2^16
        // texels per side.
        let number = |biased: &f32| usize::from(biased.to_bits() as u16);
        self.first.iter().map(number).zip(self.fraction)
    }
}

/// Locates coordinates between the centres of `len` texels.
#[inline(always)]
fn locate<U: Unit>(unit: U, mut x: Lanes<U>, len: usize) -> Neighbours {
    let last = len.saturating_sub(1) as f32;
    let mut fraction = x;
    for (x, fraction) in x.iter_mut().zip(&mut fraction) {
        let kept = lesser(x.splat(last), greater(x.splat(0.0), *x - 0.5));
        // Rounds to a whole number. For a whole `kept` the result is `kept` or the number before.
        let first = lesser(x.splat(ROUND + greater(0.0, last - 1.0)), kept - 0.5 + ROUND);
        (*x, *fraction) = (first, kept - (first - ROUND));
    }
    Neighbours { first: unit.floats(x), fraction: unit.floats(fraction) }
}

#[inline(always)]
fn lerp(a: Colour, b: Colour, share: f32) -> Colour {
    a + (b - a) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::{by_unit, level};

    const TEXELS: [[u8; 4]; 6] = [
        [255, 0, 0, 255],
        [0, 255, 0, 255],
        [0, 0, 255, 0],
        [10, 20, 30, 255],
        [40, 50, 60, 255],
        [200, 100, 50, 51],
    ];
    const TEXTURE: Texture<'_> = Texture { width: 3, height: 2, texels: &TEXELS };

    fn colour_of(texture: Texture<'_>, place: [f32; 2]) -> [f32; 4] {
        let mut out = [Vec4::ZERO; 8];
        by_unit!(level(), unit => {
            let [x, y] = place;
            let place = [unit.load(&[x; 8]), unit.load(&[y; 8])];
            texture.add(unit, place, 1.0, out.iter_mut());
        });
        assert_eq!(out, [out[0]; 8]);
        (out[0] / 255.0).to_array()
    }

    fn colour(place: [f32; 2]) -> [f32; 4] {
        colour_of(TEXTURE, place)
    }

    #[test]
    fn centres_give_their_texel_times_its_alpha() {
        assert_eq!(TEXTURE.size(), [3, 2]);
        assert_eq!(colour([0.5, 0.5]), [255.0, 0.0, 0.0, 255.0]);
        assert_eq!(colour([1.5, 1.5]), [40.0, 50.0, 60.0, 255.0]);
        assert_eq!(colour([2.5, 1.5]), [40.0, 20.0, 10.0, 51.0]);
        // A colour without alpha is invisible.
        assert_eq!(colour([2.5, 0.5]), [0.0; 4]);
    }

    #[test]
    fn between_centres_colours_are_weighed_and_beyond_them_kept() {
        assert_eq!(colour([1.25, 0.5]), [63.75, 191.25, 0.0, 255.0]);
        // A quarter of each of the first four texels.
        assert_eq!(colour([1.0, 1.0]), [76.25, 81.25, 22.5, 255.0]);
        assert_eq!(colour([-7.0, -1e30]), colour([0.5, 0.5]));
        assert_eq!(colour([1e30, 9.0]), colour([2.5, 1.5]));
        assert!(colour([f32::NAN, f32::INFINITY]).iter().all(|x| x.is_finite()));
        let empty = Texture { width: 0, height: 0, texels: &[] };
        assert_eq!(colour_of(empty, [0.0, 0.0]), [0.0; 4]);
    }
}
