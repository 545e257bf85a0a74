//! Other tools' functions of a distance, as kernels of ours: `φ(d) = factor G((epsilon d)²)`.

use sinew_runtime::kernel::Kernel;

/// A function of a distance as a kernel of a scaled distance and a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canonical {
    /// G.
    pub kernel: Kernel,
    /// What the distance is multiplied by.
    pub epsilon: f64,
    /// What the kernel is multiplied by.
    pub factor: f64,
}

/// Falloffs of pose drivers, of a radius σ: for import alone, no fit of ours solves with the hats, and
/// over rotations' angles none is positive definite for every σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// `e^(-d / σ²)`: Unreal's and RigLogic's gaussian, weightDriver's "gaussian 1"; d is not squared.
    Gaussian,
    /// `e^(-2 d / σ)`.
    Exponential,
    /// `1 - d / σ`, at least 0.
    Linear,
    /// `1 - (d / σ)³`, at least 0.
    Cubic,
    /// `1 - (d / σ)⁵`, at least 0.
    Quintic,
}

impl Falloff {
    /// Returns the falloff of a radius above 0.
    pub fn canonical(self, radius: f64) -> Canonical {
        let (kernel, epsilon) = match self {
            Self::Gaussian => (Kernel::Matern12, 1.0 / (radius * radius)),
            Self::Exponential => (Kernel::Matern12, 2.0 / radius),
            Self::Linear => (Kernel::Hat { power: 1 }, 1.0 / radius),
            Self::Cubic => (Kernel::Hat { power: 3 }, 1.0 / radius),
            Self::Quintic => (Kernel::Hat { power: 5 }, 1.0 / radius),
        };
        Canonical { kernel, epsilon, factor: 1.0 }
    }
}
