//! What a process is about: its mean.

use super::functional::Functional;
use serde::Deserialize;

/// The mean of a process, known up to its coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mean {
    /// Nothing, as S0 has it.
    Zero,
    /// A number that the observations tell.
    #[default]
    Constant,
    /// A line that they tell.
    Linear,
}

impl Mean {
    /// Counts its coefficients.
    pub const fn term_len(self) -> usize {
        match self {
            Self::Zero => 0,
            Self::Constant => 1,
            Self::Linear => 2,
        }
    }

    /// Returns what it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    /// Applies a functional to 1 and to `(x - shift) scale`, as far as it has them.
    pub(super) fn terms(self, of: &Functional, [shift, scale]: [f64; 2]) -> Vec<f64> {
        let line = (of.middle() - shift) * scale;
        let both = match of {
            Functional::Derivative { .. } => [0.0, scale],
            Functional::Value { .. } | Functional::Average { .. } => [1.0, line],
        };
        both.into_iter().take(self.term_len()).collect()
    }
}
