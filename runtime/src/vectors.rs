//! Registers of eight floats, for the vector units that a CPU has.
//!
//! Everything that runs between the choice of a level and a register is inlined always. A call in between, also of a
//! closure or of `array::map`, would compute without the level's instructions.

#[cfg(feature = "kernel")]
use crate::lanes::ROOT_HALF;
#[cfg(feature = "kernel")]
use crate::lanes::ROUND;
use crate::lanes::{EXPONENT, HALF_KEPT, HALF_SCALE, Lanes, Real, Unit};
use bytemuck::cast;
pub(crate) use fearless_simd::Level;
use fearless_simd::{Simd, f32x4, f32x8, i32x8, prelude::*, u32x8};

/// Returns the vector units to compute with.
pub(crate) fn level() -> Level {
    Level::try_detect().unwrap_or(Level::baseline())
}

/// Computes an expression with the vector units of a level.
macro_rules! by_unit {
    ($level:expr, $unit:ident => $result:expr) => {
        fearless_simd::dispatch!($level, $unit => $result)
    };
}
pub(crate) use by_unit;

impl<S: Simd> Unit for S {
    type Real = f32x8<S>;

    #[inline(always)]
    fn read(self, le: &[[u8; 4]; 8]) -> Lanes<S> {
        [read(self, le)]
    }

    #[inline(always)]
    fn load(self, floats: &[f32; 8]) -> Lanes<S> {
        [f32x8::load_array_ref(self, floats)]
    }

    #[inline(always)]
    fn floats(self, [register]: Lanes<S>) -> [f32; 8] {
        register.to_array()
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric;

    const NUMBERS: [f32; 8] =
        [0.0, -0.0, 1.0, -1.5, f32::MIN_POSITIVE, f32::INFINITY, f32::NAN, 0.7];

    /// The levels that this machine can compare.
    fn levels() -> [Level; 2] {
        [Level::baseline(), level()]
    }

    /// Returns the bits of 8 numbers, with NaNs canonicalised: their signs are arbitrary.
    fn bits(x: [f32; 8]) -> [u32; 8] {
        x.map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() })
    }

    /// Whether a formula of two numbers has equal bits in a register and as scalars, for all pairs.
    macro_rules! agree {
        (|$a:ident, $b:ident| $in_register:expr, $alone:expr) => {
            levels().into_iter().all(|level| {
                (0..8).all(|turn| {
                    let mut others = NUMBERS;
                    others.rotate_left(turn);
                    let found = by_unit!(level, unit => {
                        let ([$a], [$b]) = (unit.load(&NUMBERS), unit.load(&others));
                        unit.floats([$in_register])
                    });
                    let alone: fn(f32, f32) -> f32 = $alone;
                    let mut expected = NUMBERS;
                    expected.iter_mut().zip(others).for_each(|(a, b)| *a = alone(*a, b));
                    bits(found) == bits(expected)
                })
            })
        };
    }

    #[test]
    fn reading_keeps_order_and_bits() {
        let le = NUMBERS.map(f32::to_le_bytes);
        for level in levels() {
            let found = by_unit!(level, unit => unit.floats(Unit::read(unit, &le)));
            assert_eq!(found.map(f32::to_le_bytes), le);
        }
    }

    #[test]
    fn operations_have_the_bits_of_one() {
        assert!(agree!(|a, b| a + b, |a, b| a + b));
        assert!(agree!(|a, b| a - b, |a, b| a - b));
        assert!(agree!(|a, b| a * b, |a, b| a * b));
        assert!(agree!(|a, b| a / b, |a, b| a / b));
        assert!(agree!(|a, _b| -a, |a, _| -a));
        assert!(!agree!(|a, b| a + b, |a, b| a - b), "the measure sees");
        assert!(!agree!(|a, _b| -a, |a, _| 0.0 - a), "the measure sees a zero's sign");
    }

    #[test]
    fn choices_have_the_bits_of_one() {
        assert!(agree!(|a, b| a.where_less(b, || a, || b), |a, b| a.where_less(b, || a, || b)));
        assert!(agree!(|a, b| a.where_less(b, || a, || b), |a, b| if a < b { a } else { b }));
        assert!(!agree!(|a, b| a.where_less(b, || a, || b), |a, b| if a <= b { a } else { b }));
    }

    #[test]
    fn square_roots_have_the_bits_of_one() {
        let x = [0.0, 1e-40, 1e-9, 0.7, 2.0, 3.0, 1e30, f32::INFINITY];
        for level in levels() {
            let found = by_unit!(level, unit => {
                let [register] = unit.load(&x);
                unit.floats([register.square_root()])
            });
            assert_eq!(found, x.map(libm::sqrtf));
        }
        assert_eq!(x.map(numeric::sqrt), x.map(libm::sqrtf));
    }

    #[test]
    fn signs_and_halves_have_the_bits_of_one() {
        assert!(agree!(|a, b| a.with_sign_of(b), f32::copysign));
        assert!(!agree!(|a, b| a.with_sign_of(b), |a, _| a), "the measure sees");
        // Both halves of a word, over every bit pattern that a file may hold.
        let is_sound = |half: &u32| !matches!(half & 0x7fff, 1..0x400 | 0x7c00..);
        for half in (0..=0xffff).filter(is_sound) {
            let word = half << 16 | (0xbc00 ^ half & 0x8000);
            let [low, high] = by_unit!(level(), unit => {
                let [low, high] = halves(unit, &[word.to_le_bytes(); 8]);
                [low.to_array(), high.to_array()]
            });
            let [alone_low, alone_high] = numeric::halves(word);
            assert_eq!(low.map(f32::to_bits), [alone_low.to_bits(); 8]);
            assert_eq!(high.map(f32::to_bits), [alone_high.to_bits(); 8]);
        }
    }

    #[test]
    fn powers_of_two_are_exact() {
        for first in (-126..=120).step_by(8) {
            let k = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| first + i);
            let expected = k.map(|k| 2.0f64.powi(k) as f32);
            let x = k.map(|k| crate::lanes::ROUND + k as f32);
            assert_eq!(x.map(Real::power_of_two), expected);
            let found = by_unit!(level(), unit => {
                let [register] = unit.load(&x);
                unit.floats([register.power_of_two()])
            });
            assert_eq!(found, expected);
        }
    }

    #[cfg(feature = "kernel")]
    #[test]
    fn numbers_are_cut_at_the_root_of_a_half() {
        let root = core::f32::consts::FRAC_1_SQRT_2;
        let x = [f32::MIN_POSITIVE, f32::MAX, 1.0, root, root.next_down(), 1e-9, 3.0, 1e9];
        let (k, m) = by_unit!(level(), unit => {
            let [register] = unit.load(&x);
            let (k, m) = register.exponent_and_mantissa();
            (unit.floats([k]), unit.floats([m]))
        });
        for ((x, k), m) in x.into_iter().zip(k).zip(m) {
            assert_eq!(x.exponent_and_mantissa(), (k, m));
            assert_eq!(2.0f64.powf(f64::from(k)) * f64::from(m), f64::from(x));
            assert!(root <= m && m < 2.0 * root, "{x} {m}");
        }
    }
}
