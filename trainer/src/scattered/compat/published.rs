//! S2's solver as its post publishes it, mistakes included.
//!
//! The solver computes `θ = (MᵀM + λI)⁺ MᵀB` for a matrix M of distances, or of a function of distances. A function of
//! a distance is converted to one of our kernels: `φ(d) = factor G((epsilon d)²)`.

use crate::Error;
use crate::scattered::sum::KernelSum;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Factor of the gaussian's radius.
const FALLOFF: f64 = 0.707;
/// Radius that replaces a radius of 0 or less, where the post has this guard.
const GUARD: f64 = 0.001;

/// Functions of a distance in S2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PublishedKernel {
    /// The distance itself.
    Linear,
    /// `e^(-d² / (2 (0.707 r)²))`.
    Gaussian,
    /// `v² ln v`, v = d / r, 0 at 0.
    ThinPlate,
    /// `√(d² + r²)`.
    MultiQuadraticBiharmonic,
    /// `1 / √(d² + r²)`.
    InverseMultiQuadraticBiharmonic,
    /// `(1 - v)⁴ (4 v + 1)` if v = d / r < 1, else 0.
    BeckertWendlandC2,
}

/// Options of S2's solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedOptions {
    /// Function of a distance.
    pub kernel: PublishedKernel,
    /// Radius r.
    pub radius: f64,
    /// Regularisation λ.
    pub regularization: f64,
    /// Divides columns of the features by their length.
    pub normalise_features: bool,
    /// Divides distances by the Frobenius norm of their matrix. The post does so for all functions except the linear
    /// one.
    pub normalise_distances: bool,
}

/// Function that S2's solver finds.
#[derive(Clone, Debug)]
pub struct Published {
    /// Solution θ, m x n.
    pub theta: Mat<f64>,
    /// Lengths of the features' columns, d; 1 if the columns are not divided.
    pub feature_norms: Vec<f64>,
    /// Frobenius norm of the distances; 1 if the distances are not divided.
    pub distance_norm: f64,
    /// Condition of M: the largest singular value over the smallest.
    pub condition: f64,
    /// The function as a sum of one of our kernels.
    pub sum: KernelSum,
}

impl Published {
    /// Solves for outputs B (n x m) at features (n x d).
    ///
    /// # Errors
    /// - If there are no samples, or features and outputs have different numbers of rows.
    /// - If a distance or its function is not finite: for example the distance of a single sample over its norm of 0.
    /// - If the singular value decomposition does not converge.
    pub fn new(
        features: &Mat<f64>,
        outputs: &Mat<f64>,
        options: &PublishedOptions,
    ) -> Result<Self, Error> {
        let (n, d) = features.shape();
        if n == 0 || n != outputs.nrows() {
            let found = outputs.nrows();
            return Err(Error::mismatch(format!(
                "expected features and outputs of the same samples, found {n} and {found}"
            )));
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
                    return Err(Error::value(format!(
                        "the distance or its function between samples {row} and {column} is not finite"
                    )));
                }
                m[(row, column)] = value;
            }
        }
        let singular = m.singular_values().map_err(|_| not_converged())?;
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

    /// Converts the function to one of our kernels.
    pub fn canonical(self, radius: f64) -> Canonical {
        let (kernel, epsilon, factor) = match self {
            Self::Linear => (Kernel::Linear, 1.0, -1.0),
            Self::Gaussian => {
                let r = guarded(radius) * FALLOFF;
                (Kernel::Gaussian, 1.0 / (r * std::f64::consts::SQRT_2), 1.0)
            }
            Self::ThinPlate => (Kernel::ThinPlate, 1.0 / guarded(radius), 1.0),
            // With a radius of 0 this is the distance.
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

/// Returns the error of a singular value decomposition that does not converge.
fn not_converged() -> Error {
    Error::fit("the singular values do not converge")
}

/// Returns the pseudo-inverse. Singular values below ε n σ₁ count as 0.
fn pseudo_inverse(square: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let decomposed = square.svd().map_err(|_| not_converged())?;
    let s = decomposed.S().column_vector();
    let least = f64::EPSILON * square.nrows() as f64 * s[0];
    let inverse = Mat::from_fn(square.nrows(), square.nrows(), |k, i| {
        if s[k] > least { decomposed.U()[(i, k)] / s[k] } else { 0.0 }
    });
    Ok(decomposed.V() * inverse)
}

/// Function of a distance, as a kernel of the scaled distance and a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canonical {
    /// Kernel G.
    pub kernel: Kernel,
    /// Factor of the distance.
    pub epsilon: f64,
    /// Factor of the kernel.
    pub factor: f64,
}
