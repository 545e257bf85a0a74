//! Vector units, which compute with eight floats in a register.

use crate::lanes::{Lanes, Unit};
pub(crate) use crate::vectors::level;
use crate::vectors::read;
pub(crate) use fearless_simd::Level;
use fearless_simd::{Simd, f32x8, prelude::*};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Real;
    use crate::numeric;
    use crate::vectors::halves;

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
