//! Why nothing can be learned.

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
