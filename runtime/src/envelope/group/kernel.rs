//! Kernels of the groups' kernel maps: bell-shaped, positive definite, 1 at the centre.
//!
//! The trainer's `kernel/mod.rs` lists the steps to add a kernel.

use crate::lanes::{Real, Unit, in_lanes};
use crate::linear::{Le, Sum};
use crate::named::named;
use crate::numeric::{EXP_MAX, exp_negative, greater, lesser, one_minus_exp_negative, sqrt};
use crate::unit::{Level, by_unit};

named! {
    /// Kernel of a group, as a function of the squared scaled distance s (METHOD §2.1).
    ///
    /// The number of a kernel in the file is the kernel's place in the table of METHOD §2.1.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    pub enum GroupKernel {
        /// `e^-s`.
        Gaussian = 8, "gaussian";
        /// `e^-a`, a = √s.
        Matern12 = 9, "Matérn 1/2";
        /// `(1 + a) e^-a`, a = √(3 s).
        Matern32 = 10, "Matérn 3/2";
        /// `(1 + a + a²/3) e^-a`, a = √(5 s).
        Matern52 = 11, "Matérn 5/2";
    }
    /// Every kernel.
    pub ALL;
    /// Returns the kernel's name in FORMAT.md.
    pub name;
}

impl GroupKernel {
    /// Returns the kernel's number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the kernel with a number; `None` if there is none.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(Self::Gaussian as usize)?).copied()
    }

    /// Evaluates the kernel at a squared distance `s >= 0`: 1 at 0, finite and positive everywhere.
    pub fn value(self, s: f32) -> f32 {
        let [value] = self.values([s]);
        value
    }

    /// Computes the number `rest` of a centre t in a file: `|t|²` for a gaussian, else the kernel at x = 0.
    ///
    /// The bits are those of a kernel map at x = 0.
    pub fn at_rest(self, centre: impl IntoIterator<Item = f32>) -> f32 {
        let squared = centre.into_iter().fold(0.0, |sum, t| sum + t * t);
        if self == Self::Gaussian { squared } else { self.value(squared) }
    }

    /// Returns the factor of the centres in a file: 2 for a gaussian, else 1.
    pub const fn centre_factor(self) -> f32 {
        if matches!(self, Self::Gaussian) { 2.0 } else { 1.0 }
    }

    /// Returns the sum of which [`Self::changes`] is a function.
    #[inline(always)]
    pub(crate) fn sum(self) -> Sum {
        if self == Self::Gaussian { Sum::Gain } else { Sum::Squared }
    }

    /// Evaluates kernels of centres in blocks of 8, less the values at x = 0.
    ///
    /// - `sums`: replaced by the changes.
    pub(crate) fn changes(self, level: Level, sums: &mut [[f32; 8]], rest: &[[Le; 8]]) {
        by_unit!(level, unit => match self {
            // One loop for each kernel where code may be large.
            _ if cfg!(target_os = "none") => self.changes_of(unit, sums, rest),
            Self::Gaussian => Self::Gaussian.changes_of(unit, sums, rest),
            Self::Matern12 => Self::Matern12.changes_of(unit, sums, rest),
            Self::Matern32 => Self::Matern32.changes_of(unit, sums, rest),
            Self::Matern52 => Self::Matern52.changes_of(unit, sums, rest),
        });
    }

    #[inline(always)]
    fn changes_of<U: Unit>(self, unit: U, sums: &mut [[f32; 8]], rest: &[[Le; 8]]) {
        for (sums, rest) in sums.iter_mut().zip(rest) {
            let mut out = unit.load(sums);
            if self != Self::Gaussian {
                out = self.values(out);
            }
            for (out, rest) in out.iter_mut().zip(unit.read(rest)) {
                let is_gaussian = self == Self::Gaussian;
                *out = if is_gaussian { gaussian_change(*out, rest) } else { *out - rest };
            }
            *sums = unit.floats(out);
        }
    }

    /// Evaluates the kernel in N lanes.
    #[inline(always)]
    pub(crate) fn values<R: Real, const N: usize>(self, s: [R; N]) -> [R; N] {
        // A Matérn kernel is `(1 + p a + q a²) e^-a`, a = √(scale s). A p or q of 0 or 1 adds no rounding.
        let (scale, p, q) = match self {
            Self::Gaussian => return in_lanes(s, exp_negative),
            Self::Matern12 => (1.0, 0.0, 0.0),
            Self::Matern32 => (3.0, 1.0, 0.0),
            Self::Matern52 => (5.0, 1.0, 1.0 / 3.0),
        };
        in_lanes(
            in_lanes(s, |s| sqrt(s * scale)),
            #[inline(always)]
            |a| {
                let a = bounded(a);
                (a * p + 1.0 + a * a * q) * exp_negative(a)
            },
        )
    }
}

/// Returns `e^-s - e^-s0` for `s >= 0`, without cancellation if s is near s0.
///
/// - `gain`: `s - s0`.
/// - `rest`: s0.
#[inline(always)]
fn gaussian_change<R: Real>(gain: R, rest: R) -> R {
    let none = gain.splat(0.0);
    let greater = exp_negative(greater(none, rest + lesser(gain, none)));
    let apart = gain.where_less(none, || -gain, || gain);
    let change = greater * one_minus_exp_negative(apart);
    gain.where_less(none, || change, || -change)
}

/// Clamps a to the range of e^-a, so that the polynomial before e^-a stays finite.
#[inline(always)]
fn bounded<R: Real>(a: R) -> R {
    lesser(a.splat(EXP_MAX), a)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::unit::level;

    fn exact(kernel: GroupKernel, s: f64) -> f64 {
        let (a, b) = ((3.0 * s).sqrt(), (5.0 * s).sqrt());
        match kernel {
            GroupKernel::Gaussian => (-s).exp(),
            GroupKernel::Matern12 => (-s.sqrt()).exp(),
            GroupKernel::Matern32 => (1.0 + a) * (-a).exp(),
            GroupKernel::Matern52 => (1.0 + b + b * b / 3.0) * (-b).exp(),
        }
    }

    #[test]
    fn values_match_the_closed_forms() {
        for kernel in GroupKernel::ALL {
            let mut worst = 0.0f64;
            // Miri is slow.
            for i in (0..200_000).step_by(if cfg!(miri) { 499 } else { 1 }) {
                // Squares spread the distances evenly.
                let s = (i as f32 * 3e-5).powi(2);
                let (found, expected) = (f64::from(kernel.value(s)), exact(kernel, s.into()));
                worst = worst.max((found / expected - 1.0).abs());
            }
            // 2 ULP of the exponential, a few roundings, and the rounding of a, which e^-a magnifies.
            assert!(worst < 12e-7 && worst > 1e-8, "{kernel:?} {worst}");
        }
    }

    #[test]
    fn changes_near_rest_do_not_cancel() {
        let rest = f64::from(0.7f32);
        for gain in [-0.35f64, -1e-3, -1e-6, 0.0, 1e-9, 1e-3, 0.5, 3.0, 40.0] {
            let exact = (-rest).exp() * (-gain).exp_m1();
            let found = gaussian_change(gain as f32, rest as f32);
            assert!((f64::from(found) - exact).abs() <= 4e-7 * exact.abs(), "{gain} {found}");
        }
        assert!(gaussian_change(f32::INFINITY, 1.0).is_finite());
    }

    #[test]
    fn one_at_the_centre_and_finite_everywhere() {
        for kernel in GroupKernel::ALL {
            assert_eq!(kernel.value(0.0), 1.0);
            for s in [f32::MAX, f32::INFINITY, f32::NAN] {
                let value = kernel.value(s);
                assert!((0.0..1e-34).contains(&value), "{kernel:?} {s} {value}");
            }
            assert_eq!(GroupKernel::from_number(kernel.number()), Some(kernel));
        }
        assert_eq!(GroupKernel::from_number(7), None);
    }

    #[test]
    fn eight_lanes_have_the_bits_of_a_float() {
        let s = [0.0, 1e-9, 0.1, 0.7, 3.0, 40.0, 1e3, 1e30];
        for kernel in GroupKernel::ALL {
            let found = by_unit!(level(), unit => unit.floats(kernel.values(unit.load(&s))));
            assert_eq!(found, s.map(|s| kernel.value(s)));
        }
    }
}
