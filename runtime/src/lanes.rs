//! Eight floats side by side.
//!
//! Operations on eight floats use explicit SIMD registers. For loops over eight floats LLVM
//! generates registers at opt-level 3, scalars at opt-level 2, and memory accesses at opt-level s.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use wide::bytemuck::cast;
use wide::{f32x4, f32x8, i32x8, u32x8};

/// Eight floats in one SIMD register, which may be a pair of registers of four.
#[cfg(any(
    target_feature = "sse2",
    target_feature = "simd128",
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
))]
pub(crate) type Lanes = [Register; 1];

/// Eight floats, handled one at a time: without wide registers, loops keep the code small.
#[cfg(not(any(
    target_feature = "sse2",
    target_feature = "simd128",
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
)))]
pub(crate) type Lanes = [f32; 8];

/// A scalar type for formulas: a float, or a register of floats. Every lane has the bits of the
/// scalar.
pub(crate) trait Real:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// Returns a number in every lane of the register type of `self`.
    fn splat(self, x: f32) -> Self;

    /// Returns the correctly rounded square root of `self >= 0`.
    fn square_root(self) -> Self;

    /// Returns `then` where `self < than`, and `otherwise` elsewhere. For a single float only one
    /// closure runs.
    fn where_less(
        self,
        than: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self;

    /// Returns the magnitude of `self` with the sign of another.
    fn with_sign_of(self, other: Self) -> Self;

    /// Returns 2^k for `self` = [`ROUND`] + k, with k a whole number in [-126, 127].
    fn power_of_two(self) -> Self;

    /// Splits a normal number `self = 2^k m > 0` into k and m, with m between √(1/2) and √2.
    #[cfg(feature = "kernel")]
    fn exponent_and_mantissa(self) -> (Self, Self);
}

/// 1.5 · 2²³. Its last place is 1, so adding it rounds to a whole number.
pub(crate) const ROUND: f32 = 12_582_912.0;

/// Mask of the bits that a half-precision number keeps in single precision.
pub(crate) const HALF_KEPT: u32 = 0x8fff_e000;
/// Scale between the exponents of half and single precision. As a power of two it multiplies
/// exactly.
pub(crate) const HALF_SCALE: f32 = f32::from_bits((127 + 127 - 15) << EXPONENT);

/// Position of the exponent's lowest bit in a float.
pub(crate) const EXPONENT: u32 = 23;
/// The bits of √(1/2).
#[cfg(feature = "kernel")]
pub(crate) const ROOT_HALF: i32 = 0x3f35_04f3;

impl Real for f32 {
    #[inline(always)]
    fn splat(self, x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        Lanes::square_root_alone(self)
    }

    #[inline(always)]
    fn where_less(
        self,
        than: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if self < than { then() } else { otherwise() }
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        self.copysign(other)
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // k is in the lowest bits. The shift drops all bits above k's exponent.
        Self::from_bits((self.to_bits() << EXPONENT).wrapping_add(1.0f32.to_bits()))
    }

    #[cfg(feature = "kernel")]
    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        let bits = self.to_bits() as i32;
        let k = (bits - ROOT_HALF) >> EXPONENT;
        (k as Self, Self::from_bits((bits - (k << EXPONENT)) as u32))
    }
}

/// 8 floats in a register.
#[derive(Clone, Copy, Default)]
pub(crate) struct Register(f32x8);

impl From<f32> for Register {
    #[inline(always)]
    fn from(x: f32) -> Self {
        // `splat` and an array of eight would each be a loop through memory at opt-level s.
        let half = [x, x, x, x];
        Self(cast([half, half]))
    }
}

impl From<[f32; 8]> for Register {
    #[inline(always)]
    fn from(x: [f32; 8]) -> Self {
        Self(cast(x))
    }
}

impl Neg for Register {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// Implements an operator between registers, and between a register and a float.
macro_rules! operator {
    ($operator:ident, $apply:ident) => {
        impl $operator for Register {
            type Output = Self;

            #[inline(always)]
            fn $apply(self, other: Self) -> Self {
                Self(self.0.$apply(other.0))
            }
        }

        impl $operator<f32> for Register {
            type Output = Self;

            #[inline(always)]
            fn $apply(self, other: f32) -> Self {
                self.$apply(Self::from(other))
            }
        }

        impl $operator<Register> for f32 {
            type Output = Register;

            #[inline(always)]
            fn $apply(self, other: Register) -> Register {
                Register::from(self).$apply(other)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl AddAssign for Register {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Register {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Register {
    #[inline(always)]
    fn splat(self, x: f32) -> Self {
        Self::from(x)
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn where_less(
        self,
        than: Self,
        then: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        Self(self.0.simd_lt(than.0).select(then().0, otherwise().0))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        const SIGN: u32x8 = u32x8::new([1 << 31; 8]);
        let (own, other): (u32x8, u32x8) = (cast(self.0), cast(other.0));
        Self(cast((own & !SIGN) | (other & SIGN)))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        const ONE: u32x8 = u32x8::new([1.0f32.to_bits(); 8]);
        Self(cast((cast::<_, u32x8>(self.0) << EXPONENT) + ONE))
    }

    #[cfg(feature = "kernel")]
    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        const ROOT_HALVES: i32x8 = i32x8::new([ROOT_HALF; 8]);
        const ROUNDS: i32x8 = i32x8::new([ROUND.to_bits() as i32; 8]);
        let bits: i32x8 = cast(self.0);
        let k = (bits - ROOT_HALVES) >> EXPONENT;
        let mantissa = cast(bits - (k << EXPONENT));
        // Some targets lack an instruction that converts integers to floats.
        (Self(cast(k + ROUNDS)) - ROUND, Self(mantissa))
    }
}

/// Eight floats, readable from a file.
pub(crate) trait Eight {
    /// Returns the square root of one float, computed by the unit that computes eight.
    fn square_root_alone(x: f32) -> f32;

    /// Reads eight floats from a file.
    fn read(le: &[[u8; 4]; 8]) -> Self;

    /// Returns the eight floats in order.
    fn floats(&self) -> &[f32; 8];
}

impl Eight for [f32; 8] {
    #[inline]
    fn square_root_alone(x: f32) -> f32 {
        libm::sqrtf(x)
    }

    #[inline]
    fn read(le: &[[u8; 4]; 8]) -> Self {
        le.map(f32::from_le_bytes)
    }

    #[inline(always)]
    fn floats(&self) -> &[f32; 8] {
        self
    }
}

impl Eight for [Register; 1] {
    #[inline(always)]
    fn square_root_alone(x: f32) -> f32 {
        // libm's square root uses SSE encoding, which costs hundreds of cycles between AVX
        // instructions.
        if cfg!(target_feature = "avx") {
            let [root, ..] = f32x4::new([x, x, x, x]).sqrt().to_array();
            return root;
        }
        libm::sqrtf(x)
    }

    #[inline(always)]
    fn read(le: &[[u8; 4]; 8]) -> Self {
        // Targets with registers are little-endian.
        [Register(cast(*le))]
    }

    #[inline(always)]
    fn floats(&self) -> &[f32; 8] {
        let [Register(lanes)] = self;
        lanes.as_array()
    }
}

/// Applies a function to every lane.
#[inline(always)]
pub(crate) fn in_lanes<R: Real, const N: usize>(mut x: [R; N], f: impl Fn(R) -> R) -> [R; N] {
    for x in &mut x {
        *x = f(*x);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: [f32; 8] =
        [0.0, -0.0, 1.0, -1.5, f32::MIN_POSITIVE, f32::INFINITY, f32::NAN, 0.7];

    /// Returns the bits of 8 numbers, with NaNs canonicalised.
    fn bits(x: [f32; 8]) -> [u32; 8] {
        x.map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() })
    }

    fn register(x: [f32; 8]) -> [Register; 1] {
        Eight::read(&x.map(f32::to_le_bytes))
    }

    /// Whether a formula of two numbers has equal bits in a register and as scalars, for all pairs.
    fn agree(in_register: fn(Register, Register) -> Register, alone: fn(f32, f32) -> f32) -> bool {
        (0..8).all(|turn| {
            let mut others = NUMBERS;
            others.rotate_left(turn);
            let ([a], [b]) = (register(NUMBERS), register(others));
            let mut expected = NUMBERS;
            expected.iter_mut().zip(others).for_each(|(a, b)| *a = alone(*a, b));
            bits(*[in_register(a, b)].floats()) == bits(expected)
        })
    }

    #[test]
    fn reading_keeps_order_and_bits() {
        let le = NUMBERS.map(f32::to_le_bytes);
        assert_eq!(<[Register; 1]>::read(&le).floats().map(f32::to_le_bytes), le);
        assert_eq!(<[f32; 8]>::read(&le).floats().map(f32::to_le_bytes), le);
    }

    #[test]
    fn operations_have_the_bits_of_one() {
        assert!(agree(|a, b| a + b, |a, b| a + b));
        assert!(agree(|a, b| a - b, |a, b| a - b));
        assert!(agree(|a, b| a * b, |a, b| a * b));
        assert!(agree(|a, b| a / b, |a, b| a / b));
        assert!(agree(|a, _| -a, |a, _| -a));
        assert!(!agree(|a, b| a + b, |a, b| a - b), "the measure sees");
        assert!(!agree(|a, _| -a, |a, _| 0.0 - a), "the measure sees a zero's sign");
    }

    #[test]
    fn choices_have_the_bits_of_one() {
        let of = |a: Register, b: Register| a.where_less(b, || a, || b);
        assert!(agree(of, |a, b| a.where_less(b, || a, || b)));
        assert!(agree(of, |a, b| if a < b { a } else { b }));
        assert!(!agree(of, |a, b| if a <= b { a } else { b }), "the measure sees");
    }

    #[test]
    fn square_roots_have_the_bits_of_one() {
        let x = [0.0, 1e-40, 1e-9, 0.7, 2.0, 3.0, 1e30, f32::INFINITY];
        let [registers] = register(x).map(Real::square_root);
        assert_eq!([registers].floats(), &x.map(libm::sqrtf));
        assert_eq!(x.map(<[Register; 1]>::square_root_alone), x.map(libm::sqrtf));
        assert_eq!(x.map(<[f32; 8]>::square_root_alone), x.map(libm::sqrtf));
    }

    #[test]
    fn signs_have_the_bits_of_one() {
        // The sign of a NaN is arbitrary; the comparison canonicalises NaNs.
        assert!(agree(|a, b| a.with_sign_of(b), f32::copysign));
        assert!(!agree(|a, b| a.with_sign_of(b), |a, _| a), "the measure sees");
    }

    #[test]
    fn powers_of_two_are_exact() {
        for first in (-126..=120).step_by(8) {
            let k = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| first + i);
            let expected = k.map(|k| 2.0f64.powi(k) as f32);
            let x = k.map(|k| ROUND + k as f32);
            assert_eq!(in_lanes(x, Real::power_of_two), expected);
            assert_eq!(in_lanes(register(x), Real::power_of_two).floats(), &expected);
        }
    }

    #[cfg(feature = "kernel")]
    #[test]
    fn numbers_are_cut_at_the_root_of_a_half() {
        let root = core::f32::consts::FRAC_1_SQRT_2;
        let x = [f32::MIN_POSITIVE, f32::MAX, 1.0, root, root.next_down(), 1e-9, 3.0, 1e9];
        let [both] = register(x).map(Real::exponent_and_mantissa);
        let (k, m) = (*[both.0].floats(), *[both.1].floats());
        for ((x, k), m) in x.into_iter().zip(k).zip(m) {
            assert_eq!(x.exponent_and_mantissa(), (k, m));
            assert_eq!(2.0f64.powf(f64::from(k)) * f64::from(m), f64::from(x));
            assert!(root <= m && m < 2.0 * root, "{x} {m}");
        }
    }
}
