//! Registers of eight floats, for the vector units that a CPU has.
//!
//! Everything that runs between the choice of a level and a register is inlined always. A call in between, also of a
//! closure or of `array::map`, would compute without the level's instructions.

#[cfg(feature = "kernel")]
use crate::lanes::ROOT_HALF;
#[cfg(feature = "kernel")]
use crate::lanes::ROUND;
use crate::lanes::{EXPONENT, HALF_KEPT, HALF_SCALE, Real};
use bytemuck::cast;
use fearless_simd::{Level, Simd, f32x4, f32x8, i32x8, prelude::*, u32x8};

/// Returns the vector units to compute with.
pub(crate) fn level() -> Level {
    Level::try_detect().unwrap_or(Level::baseline())
}

impl<S: Simd> Real for f32x8<S> {
    #[inline(always)]
    fn splat(self, x: f32) -> Self {
        SimdBase::splat(self.simd, x)
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn where_less(
        self,
        than: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        self.simd_lt(than).select(then(), otherwise())
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        self.copysign(other)
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        let bits: u32x8<S> = self.bitcast();
        ((bits << EXPONENT) + 1.0f32.to_bits()).bitcast()
    }

    #[cfg(feature = "kernel")]
    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        let bits: i32x8<S> = self.bitcast();
        let k = (bits - ROOT_HALF) >> EXPONENT;
        let mantissa = bits - (k << EXPONENT);
        let rounded: Self = (k + ROUND.to_bits() as i32).bitcast();
        (rounded - ROUND, mantissa.bitcast())
    }
}

/// Reads eight floats of a file.
#[inline(always)]
pub(crate) fn read<S: Simd>(simd: S, row: &[[u8; 4]; 8]) -> f32x8<S> {
    let bits = u32x8::load_array(simd, cast(*row));
    if cfg!(target_endian = "big") {
        let [bytes, low] =
            [bits >> 24 | (bits >> 8 & 0xff00), bits << 24 | (bits << 8 & 0xff_0000)];
        return (bytes | low).bitcast();
    }
    bits.bitcast()
}

/// Decodes two half-precision numbers from each of eight words, lower halves first, as
/// [`halves`](crate::numeric::halves) does.
#[inline(always)]
pub(crate) fn halves<S: Simd>(simd: S, row: &[[u8; 4]; 8]) -> [f32x8<S>; 2] {
    let words: i32x8<S> = i32x8::load_array(simd, cast(*row));
    [half(words << 16), half(words)]
}

/// Decodes the upper halves of words.
#[inline(always)]
fn half<S: Simd>(high: i32x8<S>) -> f32x8<S> {
    let kept: f32x8<S> = ((high >> 3) & HALF_KEPT as i32).bitcast();
    kept * HALF_SCALE
}

/// Whether every float is normal: not 0, and finite.
#[inline(always)]
pub(crate) fn are_normal<S: Simd>(x: f32x8<S>) -> bool {
    (x.simd_ge(f32::MIN_POSITIVE) & x.simd_le(f32::MAX)).all_true()
}

/// Returns the four columns of eight rows.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, rows: [&[f32; 4]; 8]) -> [f32x8<S>; 4] {
    let [a, b, c, d, e, f, g, h] = rows;
    let [x, y, z, w] = four_columns(simd, [a, b, c, d]);
    let [more_x, more_y, more_z, more_w] = four_columns(simd, [e, f, g, h]);
    [x.combine(more_x), y.combine(more_y), z.combine(more_z), w.combine(more_w)]
}

/// Returns the eight rows of four columns.
#[inline(always)]
pub(crate) fn rows<S: Simd>([x, y, z, w]: [f32x8<S>; 4]) -> [f32x4<S>; 8] {
    let ((x, more_x), (y, more_y)) = (x.split(), y.split());
    let ((z, more_z), (w, more_w)) = (z.split(), w.split());
    let [a, b, c, d] = transposed([x, y, z, w]);
    let [e, f, g, h] = transposed([more_x, more_y, more_z, more_w]);
    [a, b, c, d, e, f, g, h]
}

/// Returns the four columns of four rows.
#[inline(always)]
fn four_columns<S: Simd>(simd: S, [a, b, c, d]: [&[f32; 4]; 4]) -> [f32x4<S>; 4] {
    let (a, b) = (f32x4::load_array_ref(simd, a), f32x4::load_array_ref(simd, b));
    transposed([a, b, f32x4::load_array_ref(simd, c), f32x4::load_array_ref(simd, d)])
}

#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (even, odd) = (a.zip_low(c), b.zip_low(d));
    let (more_even, more_odd) = (a.zip_high(c), b.zip_high(d));
    [
        even.zip_low(odd),
        even.zip_high(odd),
        more_even.zip_low(more_odd),
        more_even.zip_high(more_odd),
    ]
}
