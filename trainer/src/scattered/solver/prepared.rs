//! Samples as a fit sees them, and a function of what it found.

use super::options::Options;
use super::polynomial::{Polynomial, Space};
use super::samples::Samples;
use crate::scattered::sum::KernelSum;
use faer::Mat;

/// Points and polynomials of a fit.
pub(super) struct Prepared {
    /// Samples, scaled, n x d.
    pub(super) points: Mat<f64>,
    /// Polynomials of them.
    pub(super) polynomial: Polynomial,
    /// The function, with neither centres nor coefficients.
    empty: KernelSum,
}

impl Prepared {
    pub(super) fn new(samples: &Samples, options: &Options) -> Self {
        let scaling = &samples.scaling;
        let points = scaling.apply(&samples.sites) * faer::Scale(options.epsilon);
        let inputs = scaling.kept();
        let space = Space { points: &points, inputs: &inputs, tolerance: options.rank };
        let polynomial = space.determined(options.degree);
        let empty = KernelSum {
            kernel: options.kernel,
            shift: scaling.shift.clone(),
            scale: scaling.scale.iter().map(|scale| scale * options.epsilon).collect(),
            metric: None,
            centres: Mat::new(),
            terms: polynomial.terms.clone(),
            coefficients: Mat::new(),
        };
        Self { points, polynomial, empty }
    }

    /// Makes the function of centres (k x d) and of coefficients of kernels (k x m) and of monomials
    /// (T x m).
    pub(super) fn sum(
        &self,
        centres: &Mat<f64>,
        kernels: &Mat<f64>,
        monomials: &Mat<f64>,
    ) -> KernelSum {
        KernelSum {
            centres: centres.transpose().to_owned(),
            coefficients: faer::concat![[kernels.transpose(), monomials.transpose()]],
            ..self.empty.clone()
        }
    }
}
