//! The kernels for scattered data, as functions of a squared distance. The single-precision
//! formulas are shared by every backend (METHOD §2.1, §7).

use crate::envelope::GroupKernel;
use crate::lanes::{Real, in_lanes};
use crate::numeric::{exp_negative, lesser, ln, sqrt};

/// A kernel, as a function of s, the squared scaled distance; r is the square root of s (METHOD
/// §2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub enum Kernel {
    /// `-r`.
    Linear,
    /// `s ln(s) / 2`, 0 at 0.
    ThinPlate,
    /// `r³`.
    Cubic,
    /// `-r⁵`.
    Quintic,
    /// `-√(1 + s)`.
    Multiquadric,
    /// `1 / √(1 + s)`.
    InverseMultiquadric,
    /// `1 / (1 + s)`.
    InverseQuadratic,
    /// `e^-s`.
    Gaussian,
    /// `e^-r`.
    Matern12,
    /// `(1 + a) e^-a`, a = √(3 s).
    Matern32,
    /// `(1 + a + a²/3) e^-a`, a = √(5 s).
    Matern52,
    /// `(1 - r)^(l + 1) ((l + 1) r + 1)` where r < 1, else 0.
    Wendland {
        /// 2 plus half the number of dimensions for positive definiteness, rounded down.
        l: u8,
    },
    /// `1 - r^n` where r < 1, else 0: falloffs of other tools, n = 1, 3 or 5. No fit solves with a
    /// hat.
    Hat {
        /// The power, n.
        power: u8,
    },
}

impl Kernel {
    /// One kernel of each type; Wendland's for up to 3 dimensions.
    pub const ALL: [Self; 15] = [
        Self::Linear,
        Self::ThinPlate,
        Self::Cubic,
        Self::Quintic,
        Self::Multiquadric,
        Self::InverseMultiquadric,
        Self::InverseQuadratic,
        Self::Gaussian,
        Self::Matern12,
        Self::Matern32,
        Self::Matern52,
        Self::Wendland { l: 3 },
        Self::Hat { power: 1 },
        Self::Hat { power: 3 },
        Self::Hat { power: 5 },
    ];

    /// Returns its number in the file: its row in METHOD §2.1's table, or 13 for a hat.
    pub const fn number(self) -> u8 {
        match self {
            Self::Linear => 1,
            Self::ThinPlate => 2,
            Self::Cubic => 3,
            Self::Quintic => 4,
            Self::Multiquadric => 5,
            Self::InverseMultiquadric => 6,
            Self::InverseQuadratic => 7,
            Self::Gaussian => 8,
            Self::Matern12 => 9,
            Self::Matern32 => 10,
            Self::Matern52 => 11,
            Self::Wendland { .. } => 12,
            Self::Hat { .. } => 13,
        }
    }

    /// Returns its parameter in the file: l, the power, or 0.
    pub const fn parameter(self) -> u8 {
        match self {
            Self::Wendland { l } => l,
            Self::Hat { power } => power,
            _ => 0,
        }
    }

    /// Returns the kernel with a number and a parameter, if it exists: l is 2 to 66, a power 1, 3
    /// or 5.
    pub fn from_number(number: u8, parameter: u8) -> Option<Self> {
        match (number, parameter) {
            (12, l @ 2..=66) => Some(Self::Wendland { l }),
            (13, power @ (1 | 3 | 5)) => Some(Self::Hat { power }),
            (1..=11, 0) => Self::ALL.get(usize::from(number).checked_sub(1)?).copied(),
            _ => None,
        }
    }

    /// Returns its name, as in FORMAT.md.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::ThinPlate => "thin plate",
            Self::Cubic => "cubic",
            Self::Quintic => "quintic",
            Self::Multiquadric => "multiquadric",
            Self::InverseMultiquadric => "inverse multiquadric",
            Self::InverseQuadratic => "inverse quadratic",
            Self::Gaussian => "gaussian",
            Self::Matern12 => "Matérn 1/2",
            Self::Matern32 => "Matérn 3/2",
            Self::Matern52 => "Matérn 5/2",
            Self::Wendland { .. } => "Wendland",
            Self::Hat { .. } => "hat",
        }
    }
}

impl Kernel {
    /// Evaluates the kernel at a squared distance `s >= 0`.
    pub fn value(self, s: f32) -> f32 {
        let [value] = self.values([s]);
        value
    }

    /// Evaluates the kernel in N lanes.
    #[inline(always)]
    pub(super) fn values<R: Real, const N: usize>(self, s: [R; N]) -> [R; N] {
        match self {
            Self::Linear => in_lanes(
                s,
                #[inline(always)]
                |s| -sqrt(s),
            ),
            Self::ThinPlate => in_lanes(
                s,
                #[inline(always)]
                |s| s * 0.5 * ln(s),
            ),
            Self::Cubic => in_lanes(
                s,
                #[inline(always)]
                |s| s * sqrt(s),
            ),
            Self::Quintic => in_lanes(
                s,
                #[inline(always)]
                |s| -(s * s * sqrt(s)),
            ),
            Self::Multiquadric => in_lanes(
                s,
                #[inline(always)]
                |s| -sqrt(s + 1.0),
            ),
            Self::InverseMultiquadric => in_lanes(
                s,
                #[inline(always)]
                |s| s.splat(1.0) / sqrt(s + 1.0),
            ),
            Self::InverseQuadratic => in_lanes(
                s,
                #[inline(always)]
                |s| s.splat(1.0) / (s + 1.0),
            ),
            Self::Gaussian => GroupKernel::Gaussian.values(s),
            Self::Matern12 => GroupKernel::Matern12.values(s),
            Self::Matern32 => GroupKernel::Matern32.values(s),
            Self::Matern52 => GroupKernel::Matern52.values(s),
            Self::Wendland { l } => in_lanes(
                s,
                #[inline(always)]
                |s| {
                    let r = lesser(sqrt(s), s.splat(1.0));
                    let left = r.splat(1.0) - r;
                    power(left, l) * left * (r * (f32::from(l) + 1.0) + 1.0)
                },
            ),
            Self::Hat { power } => in_lanes(
                s,
                #[inline(always)]
                |s| {
                    let r = sqrt(s);
                    let fallen = match power {
                        1 => r,
                        3 => s * r,
                        _ => s * s * r,
                    };
                    let edge = r.splat(1.0);
                    r.where_less(edge, || edge - fallen, || r.splat(0.0))
                },
            ),
        }
    }

    /// Computes the slope dG/ds at a squared distance `s >= 0`. An infinite slope at 0 returns as
    /// 0, so that its product with the distance is the middle of a cone (METHOD §3).
    pub(super) fn slope(self, s: f32) -> f32 {
        let r = sqrt(s);
        let over_r = |x: f32| if r > 0.0 { x / r } else { 0.0 };
        match self {
            Self::Linear => over_r(-0.5),
            Self::ThinPlate if s > 0.0 => 0.5 * (ln(s) + 1.0),
            Self::ThinPlate => 0.0,
            Self::Cubic => 1.5 * r,
            Self::Quintic => -2.5 * s * r,
            Self::Multiquadric => -0.5 / sqrt(1.0 + s),
            Self::InverseMultiquadric => -0.5 / ((1.0 + s) * sqrt(1.0 + s)),
            Self::InverseQuadratic => -1.0 / ((1.0 + s) * (1.0 + s)),
            Self::Gaussian => -exp_negative(s),
            Self::Matern12 => over_r(-0.5 * exp_negative(r)),
            Self::Matern32 => -1.5 * exp_negative(sqrt(3.0 * s)),
            // (1 + a) e^-a with a = √(5 s) is the kernel above at 5/3 s.
            Self::Matern52 => -5.0 / 6.0 * Self::Matern32.value(5.0 / 3.0 * s),
            Self::Wendland { l } => {
                let l_1 = f32::from(l) + 1.0;
                -0.5 * l_1 * (l_1 + 1.0) * power(1.0 - lesser(r, 1.0), l)
            }
            Self::Hat { .. } if r >= 1.0 => 0.0,
            Self::Hat { power: 1 } => over_r(-0.5),
            Self::Hat { power: 3 } => -1.5 * r,
            Self::Hat { .. } => -2.5 * s * r,
        }
    }
}

impl From<GroupKernel> for Kernel {
    fn from(kernel: GroupKernel) -> Self {
        match kernel {
            GroupKernel::Gaussian => Self::Gaussian,
            GroupKernel::Matern12 => Self::Matern12,
            GroupKernel::Matern32 => Self::Matern32,
            GroupKernel::Matern52 => Self::Matern52,
        }
    }
}

/// Multiplies l factors in order.
#[inline(always)]
fn power<R: Real>(x: R, l: u8) -> R {
    (1..l).fold(x, |product, _| product * x)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::lanes::Unit;
    use crate::unit::{by_unit, level};

    fn exact(kernel: Kernel, s: f64) -> f64 {
        let r = s.sqrt();
        let (a, b) = ((3.0 * s).sqrt(), (5.0 * s).sqrt());
        match kernel {
            Kernel::Linear => -r,
            Kernel::ThinPlate => s * r.ln(),
            Kernel::Cubic => r.powi(3),
            Kernel::Quintic => -r.powi(5),
            Kernel::Multiquadric => -(1.0 + s).sqrt(),
            Kernel::InverseMultiquadric => (1.0 + s).powf(-0.5),
            Kernel::InverseQuadratic => 1.0 / (1.0 + s),
            Kernel::Gaussian => (-s).exp(),
            Kernel::Matern12 => (-r).exp(),
            Kernel::Matern32 => (1.0 + a) * (-a).exp(),
            Kernel::Matern52 => (1.0 + b + b * b / 3.0) * (-b).exp(),
            Kernel::Wendland { l } => {
                let l = f64::from(l);
                (1.0 - r).max(0.0).powf(l + 1.0) * ((l + 1.0) * r + 1.0)
            }
            Kernel::Hat { power } => (1.0 - r.powi(power.into())).max(0.0),
        }
    }

    /// Every kernel, and the flattest and steepest Wendland kernels.
    fn all() -> impl Iterator<Item = Kernel> {
        Kernel::ALL.into_iter().chain([2, 66].map(|l| Kernel::Wendland { l }))
    }

    /// Squared distances up to 9, evenly spaced in the distance, and some larger ones.
    fn distances() -> impl Iterator<Item = f32> {
        // Miri is slow.
        let near = (1..30_000).step_by(if cfg!(miri) { 499 } else { 1 });
        near.map(|i| (i as f32 * 1e-4).powi(2)).chain([1e-30, 1e-12, 40.0, 1e4, 1e8])
    }

    #[test]
    fn values_are_those_of_the_closed_forms() {
        for kernel in all() {
            let mut worst = 0.0f64;
            for s in distances() {
                let x = f64::from(s);
                let (found, expected) = (f64::from(kernel.value(s)), exact(kernel, x));
                // The last term of the bound covers the end of the exponential, times a polynomial.
                // The first terms cover roundings of the value and of r: METHOD §2.7's u times (ρ
                // |G| + |s G'|), with ρ at most 2 l + 4.
                let step = 1e-4 * x;
                let by_s = (exact(kernel, x + step) - exact(kernel, x - step)).abs() / 2e-4;
                let ulps = match kernel {
                    Kernel::Wendland { l } => 2.0 * f64::from(l) + 4.0,
                    Kernel::Hat { .. } => 6.0,
                    _ => 8.0,
                };
                // A hat subtracts from 1, and keeps the rounding of 1.
                let scale = if matches!(kernel, Kernel::Hat { .. }) { 1.0 } else { expected.abs() };
                let bound = 2f64.powi(-24) * (ulps * scale + 4.0 * by_s) + 5e-35;
                worst = worst.max((found - expected).abs() / bound);
            }
            assert!(worst <= 1.0 && worst > 0.02, "{kernel:?} {worst}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_closed_forms() {
        for kernel in all() {
            for s in distances().filter(|s| (1e-6..1e4).contains(s)) {
                let x = f64::from(s);
                // Skip the end of a kernel's bounded support.
                if (0.99..1.01).contains(&x) {
                    continue;
                }
                let step = 1e-5 * x;
                let expected = (exact(kernel, x + step) - exact(kernel, x - step)) / (2.0 * step);
                let found = f64::from(kernel.slope(s));
                let scale = expected.abs() + 1e-2 * exact(kernel, x).abs().min(1.0);
                assert!((found - expected).abs() <= 2e-4 * scale + 1e-9, "{kernel:?} {s} {found}");
            }
            assert!(kernel.slope(0.0).is_finite());
        }
    }

    #[test]
    fn at_the_centre_and_far_away() {
        for kernel in all() {
            let falls = exact(kernel, 1e6) == 0.0 || exact(kernel, 1e6).abs() < 1e-2;
            let at_centre = kernel.value(0.0);
            assert!(at_centre == f32::from(u8::from(falls)) || at_centre == -1.0, "{kernel:?}");
            let far = kernel.value(f32::INFINITY);
            assert!(if falls { far.abs() < 1e-18 } else { far.is_infinite() }, "{kernel:?} {far}");
        }
    }

    #[test]
    fn eight_lanes_have_the_bits_of_one() {
        let s = [0.0, 1e-9, 0.1, 0.7, 0.98, 3.0, 40.0, 1e30];
        for kernel in all() {
            let found = by_unit!(level(), unit => unit.floats(kernel.values(unit.load(&s))));
            assert_eq!(found.map(f32::to_bits), s.map(|s| kernel.value(s).to_bits()));
        }
    }

    #[test]
    fn numbers_and_parameters_name_one_kernel() {
        for kernel in Kernel::ALL {
            assert_eq!(Kernel::from_number(kernel.number(), kernel.parameter()), Some(kernel));
        }
        for (number, parameter) in [(0, 0), (8, 1), (12, 1), (12, 67), (13, 0), (13, 2), (14, 0)] {
            assert_eq!(Kernel::from_number(number, parameter), None);
        }
    }

    #[test]
    fn kernels_of_groups_keep_their_numbers() {
        for kernel in GroupKernel::ALL {
            let all = Kernel::from(kernel);
            assert_eq!((all.number(), all.name()), (kernel.number(), kernel.name()));
        }
    }
}
