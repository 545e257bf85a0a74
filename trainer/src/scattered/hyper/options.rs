//! Options and traces of learning.

use crate::Error;
use faer::Mat;
use serde::Deserialize;
use sinew_runtime::kernel::Kernel;

/// Options of learning.
#[derive(Clone, Debug)]
pub struct Options {
    /// Kernel G.
    pub kernel: Kernel,
    /// Number of centres, n.
    pub centres: usize,
    /// Degree of the polynomial; `None` for no polynomial.
    pub degree: Option<usize>,
    /// Ridge λ: `λ N (|c|² + |b|²)` is part of the energy (METHOD §2.2).
    ///
    /// Without a ridge, kernels that coincide or become flat have unbounded coefficients. A ridge of 1e-9 prevents
    /// this.
    pub ridge: f64,
    /// Metric W.
    pub metric: Metric,
    /// Choice of the samples where centres start.
    pub start: Start,
    /// Method that moves the centres.
    pub method: Method,
    /// A seed for each start. The first start with the least energy is kept.
    pub seeds: Vec<u64>,
    /// Largest number of energy evaluations per start, including the start.
    pub evaluations: usize,
}

/// Metric W; distances are |W (u - t)|.
#[derive(Clone, Debug)]
pub struct Metric {
    /// Initial metric, e x d: of low rank if e < d.
    pub start: Mat<f64>,
    /// Learned entries.
    pub learned: Entries,
}

impl Metric {
    /// Starts with a multiple of I, d x d, or with the rows of I added up to e rows, e x d.
    ///
    /// Kernels about as wide as the spacing of the centres end better than wider kernels.
    pub fn scaled(rows: usize, inputs: usize, by: f64, learned: Entries) -> Self {
        let start = Mat::from_fn(rows, inputs, |r, c| if r == c % rows { by } else { 0.0 });
        Self { start, learned }
    }
}

/// Entries of a metric, by the names that a person writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Entries {
    /// No entry: the metric is fixed.
    #[serde(rename = "fixed")]
    None,
    /// Entries on the diagonal: a weight per input.
    #[default]
    #[serde(rename = "diagonal")]
    Diagonal,
    /// All entries.
    #[serde(rename = "full")]
    All,
}

/// Choice of the samples where centres start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Samples with equal probability.
    Random,
    /// Samples with a probability proportional to their squared distance from the earlier ones (Arthur and
    /// Vassilvitskii 2007).
    KMeansPlusPlus,
}

/// Method that moves centres and metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Solves for the coefficients exactly at every step, and for the rest by L-BFGS.
    VariableProjection,
    /// Follows S1's dynamical system: all parameters move down the gradient, times ω.
    GradientFlow {
        /// Initial ω. It is halved for good whenever the energy would rise.
        step: f64,
    },
    /// Makes S1's random changes, accepted with probability `min(1, e^(-ΔE/T))`, and solves for the coefficients
    /// exactly.
    Metropolis {
        /// Largest change, in units of u and of W.
        reach: f64,
        /// T at the start and at the end; linear in the number of evaluations.
        temperatures: [f64; 2],
    },
}

/// Steps of learning from one seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Seed of the start.
    pub seed: u64,
    /// Energy E of the start, with solved coefficients.
    pub start: f64,
    /// Steps in order.
    pub steps: Vec<Step>,
    /// Number of evaluations of E, including the start.
    pub evaluations: usize,
}

/// Step of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Energy E after the step.
    pub energy: f64,
    /// Whether the step was accepted. A refused step of a gradient flow halves ω.
    pub accepted: bool,
}

/// Returns the error of a number that is out of its range.
pub(super) fn wrong_number(name: &str, found: f64) -> Error {
    Error::value(format!("{name} must be finite and not negative, found {found}"))
}
