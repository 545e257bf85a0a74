//! S2's solver as its post publishes it, with what it gets wrong: `θ = (MᵀM + λI)⁺ MᵀB` over a matrix M of
//! distances, or of a function of them.
//! Other tools' functions of a distance, as kernels of ours: `φ(d) = factor G((epsilon d)²)`.

use crate::scattered::sum::KernelSum;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// The gaussian's falloff.
const FALLOFF: f64 = 0.707;
/// What a radius that is not positive is taken for, where the post guards it.
const GUARD: f64 = 0.001;

/// S2's functions of a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PublishedKernel {
    /// The distance.
    Linear,
    /// `e^(-d² / (2 (0.707 r)²))`.
    Gaussian,
    /// `v² ln v`, v = d / r, 0 at 0.
    ThinPlate,
    /// `√(d² + r²)`.
    MultiQuadraticBiharmonic,
    /// `1 / √(d² + r²)`.
    InverseMultiQuadraticBiharmonic,
    /// `(1 - v)⁴ (4 v + 1)` where v = d / r < 1, else 0.
    BeckertWendlandC2,
}

/// What S2's solver is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedOptions {
    /// The function.
    pub kernel: PublishedKernel,
    /// r.
    pub radius: f64,
    /// λ.
    pub regularization: f64,
    /// Columns of the features are divided by their length.
    pub normalise_features: bool,
    /// Distances are divided by their matrix's Frobenius norm: the post does so of all functions but the
    /// linear one.
    pub normalise_distances: bool,
}

/// A function as S2 solves for it.
#[derive(Clone, Debug)]
pub struct Published {
    /// θ, m x n.
    pub theta: Mat<f64>,
    /// Lengths of the features' columns, d; 1 where they are not divided by it.
    pub feature_norms: Vec<f64>,
    /// The distances' norm; 1 where they are not divided by it.
    pub distance_norm: f64,
    /// Condition of M: the largest singular value over the least.
    pub condition: f64,
    /// The same function as a sum of a kernel of ours.
    pub sum: KernelSum,
}

/// Where S2's solver has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PublishedError {
    /// Features and outputs are none, or not as many.
    #[error("expected features and outputs of the same samples, found {features} and {outputs}")]
    Rows {
        /// Rows of the features.
        features: usize,
        /// Rows of the outputs.
        outputs: usize,
    },
    /// Features, or the function of their distances, are not finite.
    #[error("the distance or its function between samples {row} and {column} is not finite")]
    NotFinite {
        /// A sample.
        row: usize,
        /// Another, or the same.
        column: usize,
    },
    /// The singular values are not found.
    #[error("the singular values do not converge")]
    Singular,
}

impl Published {
    /// Solves for outputs B (n x m) at features (n x d).
    ///
    /// # Errors
    /// If features and outputs are none or not as many; if a distance or its function is not finite, as
    /// that of a single sample over its norm of 0; if no singular values are found.
    pub fn new(
        features: &Mat<f64>,
        outputs: &Mat<f64>,
        options: &PublishedOptions,
    ) -> Result<Self, PublishedError> {
        let (n, d) = features.shape();
        if n == 0 || n != outputs.nrows() {
            return Err(PublishedError::Rows { features: n, outputs: outputs.nrows() });
        }
        let norm = |c: usize| match features.col(c).norm_l2() {
            norm if options.normalise_features && norm != 0.0 => norm,
            _ => 1.0,
        };
        let feature_norms: Vec<f64> = (0..d).map(norm).collect();
        let divided = Mat::from_fn(n, d, |i, c| features[(i, c)] / feature_norms[c]);
        let distance = |i: usize, k: usize| -> f64 {
            (0..d).map(|c| (divided[(i, c)] - divided[(k, c)]).powi(2)).sum::<f64>().sqrt()
        };
        let mut m = Mat::from_fn(n, n, distance);
        let distance_norm = if options.normalise_distances { m.norm_l2() } else { 1.0 };
        for column in 0..n {
            for row in 0..n {
                let value = options.kernel.value(m[(row, column)] / distance_norm, options.radius);
                if !value.is_finite() {
                    return Err(PublishedError::NotFinite { row, column });
                }
                m[(row, column)] = value;
            }
        }
        let singular = m.singular_values().map_err(|_| PublishedError::Singular)?;
        let condition = singular[0] / singular[n - 1];
        let transposed = m.transpose();
        let mut square = transposed * &m;
        (0..n).for_each(|i| square[(i, i)] += options.regularization);
        let inverse = pseudo_inverse(&square)?;
        let theta = (inverse * transposed * outputs).transpose().to_owned();
        let Canonical { kernel, epsilon, factor } = options.kernel.canonical(options.radius);
        let epsilon = epsilon / distance_norm;
        let sum = KernelSum {
            kernel,
            shift: vec![0.0; d],
            scale: feature_norms.iter().map(|norm| epsilon / norm).collect(),
            metric: None,
            centres: Mat::from_fn(d, n, |c, k| divided[(k, c)] * epsilon),
            terms: Vec::new(),
            coefficients: &theta * faer::Scale(factor),
        };
        Ok(Self { theta, feature_norms, distance_norm, condition, sum })
    }
}

impl PublishedKernel {
    /// Evaluates the function of a distance and a radius.
    pub fn value(self, distance: f64, radius: f64) -> f64 {
        let v = distance / guarded(radius);
        match self {
            Self::Linear => distance,
            Self::Gaussian => {
                let r = guarded(radius) * FALLOFF;
                (-(distance * distance) / (2.0 * r * r)).exp()
            }
            Self::ThinPlate if v > 0.0 => v * v * v.ln(),
            Self::ThinPlate => v,
            Self::MultiQuadraticBiharmonic => (distance * distance + radius * radius).sqrt(),
            Self::InverseMultiQuadraticBiharmonic => {
                1.0 / (distance * distance + radius * radius).sqrt()
            }
            Self::BeckertWendlandC2 => {
                let first = if 1.0 - v > 0.0 { (1.0 - v).powi(4) } else { 0.0 };
                first * (4.0 * v + 1.0)
            }
        }
    }

    /// Returns the function as a kernel of ours.
    pub fn canonical(self, radius: f64) -> Canonical {
        let (kernel, epsilon, factor) = match self {
            Self::Linear => (Kernel::Linear, 1.0, -1.0),
            Self::Gaussian => {
                let r = guarded(radius) * FALLOFF;
                (Kernel::Gaussian, 1.0 / (r * std::f64::consts::SQRT_2), 1.0)
            }
            Self::ThinPlate => (Kernel::ThinPlate, 1.0 / guarded(radius), 1.0),
            // Without a radius it is the distance.
            Self::MultiQuadraticBiharmonic if radius == 0.0 => (Kernel::Linear, 1.0, -1.0),
            Self::MultiQuadraticBiharmonic => {
                (Kernel::Multiquadric, 1.0 / radius.abs(), -radius.abs())
            }
            Self::InverseMultiQuadraticBiharmonic => {
                (Kernel::InverseMultiquadric, 1.0 / radius.abs(), 1.0 / radius.abs())
            }
            Self::BeckertWendlandC2 => (Kernel::Wendland { l: 3 }, 1.0 / guarded(radius), 1.0),
        };
        Canonical { kernel, epsilon, factor }
    }
}

fn guarded(radius: f64) -> f64 {
    if radius > 0.0 { radius } else { GUARD }
}

/// Returns the pseudo-inverse, with singular values below ε n σ₁ taken for 0.
fn pseudo_inverse(square: &Mat<f64>) -> Result<Mat<f64>, PublishedError> {
    let decomposed = square.svd().map_err(|_| PublishedError::Singular)?;
    let s = decomposed.S().column_vector();
    let least = f64::EPSILON * square.nrows() as f64 * s[0];
    let inverse = Mat::from_fn(square.nrows(), square.nrows(), |k, i| {
        if s[k] > least { decomposed.U()[(i, k)] / s[k] } else { 0.0 }
    });
    Ok(decomposed.V() * inverse)
}

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
