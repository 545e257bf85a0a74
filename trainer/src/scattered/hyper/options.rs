//! What is asked of a learning.
//! Why nothing can be learned.

use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// What to learn, how, and for how long.
#[derive(Clone, Debug)]
pub struct Options {
    /// G.
    pub kernel: Kernel,
    /// How many centres, n.
    pub centres: usize,
    /// Degree of the polynomial, if there is one.
    pub degree: Option<usize>,
    /// λ: `λ N (|c|² + |b|²)` is part of the energy (METHOD §2.2). Without it kernels that come to lie
    /// on each other, or flat, have coefficients without bound; 1e-9 is enough against that.
    pub ridge: f64,
    /// W.
    pub metric: Metric,
    /// Where centres start.
    pub start: Start,
    /// How they move.
    pub method: Method,
    /// A start each; the one of the least energy is kept, the first of equals.
    pub seeds: Vec<u64>,
    /// How often the energy may be evaluated from each start, itself included.
    pub evaluations: usize,
}

/// The metric W; distances are |W (u - t)|.
#[derive(Clone, Debug)]
pub struct Metric {
    /// Where it starts, e x d: of low rank where e < d.
    pub start: Mat<f64>,
    /// What of it is learned.
    pub learned: Entries,
}

impl Metric {
    /// Starts as a multiple of I, d x d, or of its rows added up to fewer, e x d. Kernels about as wide
    /// as centres are apart end better than wider ones.
    pub fn scaled(rows: usize, inputs: usize, by: f64, learned: Entries) -> Self {
        let start = Mat::from_fn(rows, inputs, |r, c| if r == c % rows { by } else { 0.0 });
        Self { start, learned }
    }
}

/// Entries of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {
    /// None: the metric is fixed.
    None,
    /// Those on the diagonal: a weight an input.
    Diagonal,
    /// All.
    All,
}

/// The samples on which centres start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Any, each as likely.
    Random,
    /// Each next one as likely as its squared distance from those before (Arthur and Vassilvitskii
    /// 2007).
    KMeansPlusPlus,
    /// Each next one where those before leave the largest residual; no seed changes it.
    Greedy,
}

/// How centres and metric move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// Coefficients solved exactly at every step, the rest by L-BFGS.
    #[default]
    VariableProjection,
    /// S1's dynamical system: everything down the gradient, times ω.
    GradientFlow {
        /// ω at first; it is halved for good where the energy would rise.
        step: f64,
    },
    /// S1's random changes, taken with probability `min(1, e^(-ΔE/T))`; coefficients solved exactly.
    Metropolis {
        /// How far a change goes at most, in units of u and of W.
        reach: f64,
        /// T at first and at last: linear between, by evaluations.
        temperatures: [f64; 2],
    },
}

/// A learning that cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HyperError {
    /// The kernel is a hat.
    #[error("nothing can be learned with a hat: it is for evaluation alone")]
    Hat,
    /// There is nothing to learn from.
    #[error("nothing to learn from: {samples} samples of {inputs} inputs and {values} values")]
    Empty {
        /// N.
        samples: usize,
        /// d.
        inputs: usize,
        /// m.
        values: usize,
    },
    /// An argument does not fit the samples.
    #[error("{name}: expected {expected}, found {found}")]
    Length {
        /// What is counted.
        name: &'static str,
        /// As many as the samples ask for.
        expected: usize,
        /// As many as were given.
        found: usize,
    },
    /// A number is out of its range.
    #[error("{name} must be finite and not negative, found {found}")]
    Number {
        /// Its name.
        name: &'static str,
        /// Its value.
        found: f64,
    },
    /// No centre is asked for.
    #[error("no centre is asked for")]
    NoCentres,
    /// No seed is given.
    #[error("no seed is given")]
    NoSeeds,
    /// More coefficients than samples.
    #[error(
        "{centres} centres and a polynomial of {terms} terms need as many samples, found {samples}"
    )]
    TooFewSamples {
        /// n.
        centres: usize,
        /// Monomials.
        terms: usize,
        /// N.
        samples: usize,
    },
    /// A sample, or what the start makes of it, is not finite.
    #[error("the energy is not finite where seed {seed} starts: a sample or the metric is not")]
    NotFinite {
        /// The first such seed.
        seed: u64,
    },
}

/// A learning from one seed, step by step.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Whence.
    pub seed: u64,
    /// E of the start, its coefficients solved.
    pub start: f64,
    /// In order.
    pub steps: Vec<Step>,
    /// How often E was evaluated, the start included.
    pub evaluations: usize,
    /// Why there are no more steps.
    pub stop: Stop,
}

/// A step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// E after it.
    pub energy: f64,
    /// Whether it was taken. One that a gradient flow refuses halves ω.
    pub accepted: bool,
}

/// Why a learning stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The evaluations are used up.
    Budget,
    /// The last steps hardly lowered the energy.
    Settled,
    /// No step along the gradient lowers the energy.
    NoDescent,
}

impl Trace {
    /// Returns how many steps were taken.
    pub fn accepted(&self) -> usize {
        self.steps.iter().filter(|step| step.accepted).count()
    }
}
