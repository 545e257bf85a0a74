//! The kernels in f64, as functions of s, the squared scaled distance (METHOD §2.1).

use serde::Serializer;
use sinew_runtime::envelope::GroupKernel;

/// Every kernel, the smoothest first.
pub const SMOOTHEST_FIRST: [GroupKernel; 4] =
    [GroupKernel::Gaussian, GroupKernel::Matern52, GroupKernel::Matern32, GroupKernel::Matern12];

/// A kernel in f64.
pub trait Exact {
    /// Evaluates the kernel: 1 at s = 0.
    fn exact(self, s: f64) -> f64;

    /// Returns -√s G'(s), how steeply the kernel falls with the distance: half of -dG/d√s.
    fn steepness(self, s: f64) -> f64;
}

impl Exact for GroupKernel {
    fn exact(self, s: f64) -> f64 {
        let a = argument(self, s);
        let factor = match self {
            Self::Gaussian | Self::Matern12 => 1.0,
            Self::Matern32 => 1.0 + a,
            Self::Matern52 => 1.0 + a + a * a / 3.0,
        };
        factor * (-a).exp()
    }

    fn steepness(self, s: f64) -> f64 {
        let a = argument(self, s);
        let factor = match self {
            Self::Gaussian => s.sqrt(),
            Self::Matern12 => 0.5,
            Self::Matern32 => 3f64.sqrt() * a / 2.0,
            Self::Matern52 => 5f64.sqrt() * a * (1.0 + a) / 6.0,
        };
        factor * (-a).exp()
    }
}

/// Returns what the exponential takes.
fn argument(kernel: GroupKernel, s: f64) -> f64 {
    match kernel {
        GroupKernel::Gaussian => s,
        GroupKernel::Matern12 => s.sqrt(),
        GroupKernel::Matern32 => (3.0 * s).sqrt(),
        GroupKernel::Matern52 => (5.0 * s).sqrt(),
    }
}

/// Writes a kernel by its name.
pub fn by_name<S: Serializer>(kernel: &GroupKernel, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kernel.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steepness_is_the_slope_of_the_value() {
        for kernel in SMOOTHEST_FIRST {
            for r in [0.1f64, 0.7, 2.0] {
                let h = 1e-5;
                let at = |r: f64| kernel.exact(r * r);
                let slope = (at(r + h) - at(r - h)) / (2.0 * h);
                assert!((slope + 2.0 * kernel.steepness(r * r)).abs() < 1e-9, "{kernel:?} {r}");
            }
        }
    }

    #[test]
    fn kernels_are_one_at_their_centre_and_fall() {
        for kernel in SMOOTHEST_FIRST {
            assert_eq!(kernel.exact(0.0), 1.0);
            let values: Vec<f64> = (0..30).map(|i| kernel.exact(f64::from(i))).collect();
            assert!(values.is_sorted_by(|a, b| a > b) && values[29] > 0.0 && values[29] < 0.01);
        }
    }
}
