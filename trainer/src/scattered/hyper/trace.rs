//! What a learning did.

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
