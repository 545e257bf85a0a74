//! Kernels in f64, as functions of s, the squared scaled distance (METHOD §2.1).

use serde::Serializer;
use sinew_runtime::envelope::GroupKernel;
use sinew_runtime::kernel::Kernel;

/// Kernels of an envelope's groups, the smoothest first.
pub const SMOOTHEST_FIRST: [GroupKernel; 4] =
    [GroupKernel::Gaussian, GroupKernel::Matern52, GroupKernel::Matern32, GroupKernel::Matern12];

/// A kernel in f64. Exponentials, logarithms and powers are libm's: the same bits on any CPU.
pub trait Exact: Into<Kernel> {
    /// Evaluates G at `s >= 0`.
    fn exact(self, s: f64) -> f64 {
        let r = s.sqrt();
        match self.into() {
            Kernel::Linear => -r,
            Kernel::ThinPlate if s == 0.0 => 0.0,
            Kernel::ThinPlate => 0.5 * s * libm::log(s),
            Kernel::Cubic => s * r,
            Kernel::Quintic => -s * s * r,
            Kernel::Multiquadric => -(1.0 + s).sqrt(),
            Kernel::InverseMultiquadric => 1.0 / (1.0 + s).sqrt(),
            Kernel::InverseQuadratic => 1.0 / (1.0 + s),
            Kernel::Gaussian => libm::exp(-s),
            Kernel::Matern12 => libm::exp(-r),
            Kernel::Matern32 => {
                let a = (3.0 * s).sqrt();
                (1.0 + a) * libm::exp(-a)
            }
            Kernel::Matern52 => {
                let a = (5.0 * s).sqrt();
                (1.0 + a + a * a / 3.0) * libm::exp(-a)
            }
            Kernel::Wendland { l } => {
                let power = f64::from(l) + 1.0;
                libm::pow((1.0 - r).max(0.0), power) * (power * r + 1.0)
            }
            Kernel::Hat { power } => (1.0 - libm::pow(r, power.into())).max(0.0),
        }
    }

    /// Returns the slope dG/ds at `s >= 0`.
    ///
    /// If the slope at 0 is infinite, this returns 0. The product of slope and distance then has its limit, or the
    /// middle value at a cone.
    fn slope(self, s: f64) -> f64 {
        let r = s.sqrt();
        let over_r = |value: f64| if r > 0.0 { value / r } else { 0.0 };
        match self.into() {
            Kernel::Linear => -over_r(0.5),
            Kernel::ThinPlate if s == 0.0 => 0.0,
            Kernel::ThinPlate => 0.5 * (libm::log(s) + 1.0),
            Kernel::Cubic => 1.5 * r,
            Kernel::Quintic => -2.5 * s * r,
            Kernel::Multiquadric => -0.5 / (1.0 + s).sqrt(),
            Kernel::InverseMultiquadric => -0.5 / ((1.0 + s) * (1.0 + s).sqrt()),
            Kernel::InverseQuadratic => -1.0 / ((1.0 + s) * (1.0 + s)),
            Kernel::Gaussian => -libm::exp(-s),
            Kernel::Matern12 => -over_r(0.5 * libm::exp(-r)),
            Kernel::Matern32 => -1.5 * libm::exp(-(3.0 * s).sqrt()),
            Kernel::Matern52 => {
                let a = (5.0 * s).sqrt();
                -5.0 / 6.0 * (1.0 + a) * libm::exp(-a)
            }
            Kernel::Wendland { l } => {
                let power = f64::from(l) + 1.0;
                -0.5 * power * (power + 1.0) * libm::pow((1.0 - r).max(0.0), power - 1.0)
            }
            Kernel::Hat { .. } if r >= 1.0 => 0.0,
            Kernel::Hat { power: 1 } => -over_r(0.5),
            Kernel::Hat { power } => {
                let power = f64::from(power);
                -0.5 * power * libm::pow(r, power - 2.0)
            }
        }
    }

    /// Returns -√s G'(s), how steeply the kernel falls with the distance: half of -dG/d√s.
    fn steepness(self, s: f64) -> f64 {
        match self.into() {
            Kernel::Linear => 0.5,
            Kernel::Matern12 => 0.5 * libm::exp(-s.sqrt()),
            kernel => -s.sqrt() * kernel.slope(s),
        }
    }
}

impl Exact for Kernel {}
impl Exact for GroupKernel {}

/// Returns the order of a kernel's conditional definiteness; `None` for a hat, with which no system can be solved.
///
/// The order is one more than the lowest degree of polynomial that a fit with the kernel needs.
pub const fn order(kernel: Kernel) -> Option<usize> {
    match kernel {
        Kernel::Linear | Kernel::Multiquadric => Some(1),
        Kernel::ThinPlate | Kernel::Cubic => Some(2),
        Kernel::Quintic => Some(3),
        Kernel::Hat { .. } => None,
        _ => Some(0),
    }
}

/// Returns true if scaling all distances leaves the interpolant unchanged.
pub const fn is_scale_invariant(kernel: Kernel) -> bool {
    matches!(kernel, Kernel::Linear | Kernel::ThinPlate | Kernel::Cubic | Kernel::Quintic)
}

/// Writes a kernel by its name.
pub fn by_name<S: Serializer>(
    kernel: &(impl Copy + Into<Kernel>),
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str((*kernel).into().name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_differences_of_values() {
        for kernel in Kernel::ALL {
            for r in [0.1f64, 0.7, 0.95, 2.0] {
                let h = 1e-5;
                let at = |r: f64| kernel.exact(r * r);
                let slope = (at(r + h) - at(r - h)) / (2.0 * h);
                let scale = 1.0 + slope.abs();
                assert!(
                    (slope - 2.0 * r * kernel.slope(r * r)).abs() < 1e-8 * scale,
                    "{kernel:?} {r}"
                );
                assert!(
                    (slope + 2.0 * kernel.steepness(r * r)).abs() < 1e-8 * scale,
                    "{kernel:?} {r}"
                );
            }
            assert!(kernel.slope(0.0).is_finite());
        }
    }

    #[test]
    fn kernels_of_groups_are_one_at_their_centre_and_fall() {
        for kernel in SMOOTHEST_FIRST {
            assert_eq!(kernel.exact(0.0), 1.0);
            let values: Vec<f64> = (0..30).map(|i| kernel.exact(f64::from(i))).collect();
            assert!(values.is_sorted_by(|a, b| a > b) && values[29] > 0.0 && values[29] < 0.01);
        }
    }
}
