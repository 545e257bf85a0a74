//! Eight floats side by side, and the operations of formulas on them.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

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
        // libm's square root uses SSE encoding, which costs hundreds of cycles between AVX instructions.
        #[cfg(target_feature = "avx")]
        {
            use fearless_simd::{Level, dispatch, f32x4, prelude::*};
            let [root, ..] =
                dispatch!(Level::baseline(), simd => f32x4::splat(simd, self).sqrt().to_array());
            root
        }
        #[cfg(not(target_feature = "avx"))]
        libm::sqrtf(self)
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

/// What computes with eight floats: vector registers, or one float at a time.
pub(crate) trait Unit: Copy {
    /// A float, or a register of eight.
    type Real: Real + AddAssign;

    /// Reads eight floats from a file.
    fn read(self, le: &[[u8; 4]; 8]) -> Lanes<Self>;

    /// Loads eight floats.
    fn load(self, floats: &[f32; 8]) -> Lanes<Self>;

    /// Returns the eight floats in order.
    fn floats(self, lanes: Lanes<Self>) -> [f32; 8];
}

/// Eight floats, for loops over registers or floats.
///
/// Loops over eight floats need explicit registers: LLVM generates registers at opt-level 3, scalars at opt-level 2, and
/// memory accesses at opt-level s.
pub(crate) type Lanes<U> = [<U as Unit>::Real; WIDTH];

/// Length of [`Lanes`]: 1 where `lib.rs` chooses vector units. Without them one float is handled at a time.
pub(crate) const WIDTH: usize = if cfg!(all(
    not(target_os = "none"),
    any(
        target_feature = "sse2",
        target_feature = "simd128",
        all(target_arch = "aarch64", target_feature = "neon")
    )
)) {
    1
} else {
    8
};

/// Applies a function to every lane.
#[inline(always)]
pub(crate) fn in_lanes<R: Real, const N: usize>(mut x: [R; N], f: impl Fn(R) -> R) -> [R; N] {
    for x in &mut x {
        *x = f(*x);
    }
    x
}
