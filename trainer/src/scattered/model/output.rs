//! Outputs of a function: what its values are made to.

use crate::regression::rotations::{RotationError, Xyzw, from_values, to_values};
use sinew_runtime::kernel::Normalise;

/// Least sum that outputs are divided by.
pub(super) const LEAST_SUM: f64 = 1e-12;

/// A named output.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: OutputKind,
}

/// What an output is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutputKind {
    /// A number.
    Scalar {
        /// The least that it is.
        low: f64,
        /// The most that it is.
        high: f64,
        /// Whether it is one of those whose sum is made 1.
        normalised: bool,
        /// What it is where the function has faded.
        neutral: f64,
    },
    /// Three numbers of one unit.
    Vector3 {
        /// What it is where the function has faded.
        neutral: [f64; 3],
    },
    /// A quaternion, x, y, z, w.
    Rotation {
        /// What it is where the function has faded, and about which it blends; of length 1.
        neutral: Xyzw,
    },
}

impl OutputKind {
    /// Returns how many values of the function it takes.
    pub const fn value_len(self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Vector3 { .. } | Self::Rotation { .. } => 3,
        }
    }

    /// Returns how many numbers it is.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Vector3 { .. } => 3,
            Self::Rotation { .. } => 4,
        }
    }

    /// Turns a sample's numbers to values of the function.
    ///
    /// # Errors
    /// If a rotation is none.
    pub fn to_values(self, numbers: &[f64]) -> Result<Vec<f64>, RotationError> {
        match (self, numbers) {
            (Self::Rotation { neutral }, &[x, y, z, w]) => {
                Ok(to_values(neutral, [x, y, z, w])?.to_vec())
            }
            _ => Ok(numbers.to_vec()),
        }
    }

    /// Returns the values where the function has faded.
    pub(super) fn neutral(self) -> Vec<f64> {
        match self {
            Self::Scalar { neutral, .. } => vec![neutral],
            Self::Vector3 { neutral } => neutral.to_vec(),
            Self::Rotation { .. } => vec![0.0; 3],
        }
    }

    /// Turns values to numbers.
    fn numbers(self, values: &[f64]) -> Result<Vec<f64>, RotationError> {
        match (self, values) {
            (Self::Scalar { low, high, .. }, &[value]) => Ok(vec![value.max(low).min(high)]),
            (Self::Rotation { neutral }, &[x, y, z]) => {
                Ok(from_values(neutral, [x, y, z])?.to_vec())
            }
            _ => Ok(values.to_vec()),
        }
    }
}

/// Makes the numbers of all outputs of a function's values.
///
/// # Errors
/// If a neutral rotation is none.
pub(super) fn finish(
    outputs: &[Output],
    normalise: Normalise,
    values: &[f64],
) -> Result<Vec<f64>, RotationError> {
    let (mut rest, mut out, mut marked) = (values, Vec::new(), Vec::new());
    for Output { kind, .. } in outputs {
        let own;
        (own, rest) = rest.split_at(kind.value_len());
        if matches!(kind, OutputKind::Scalar { normalised: true, .. }) {
            marked.push(out.len());
        }
        out.extend(kind.numbers(own)?);
    }
    let sum: f64 = marked.iter().map(|&at| out[at]).sum();
    let divides = match normalise {
        Normalise::Never => false,
        Normalise::Always => sum > LEAST_SUM,
        Normalise::AboveOne => sum > 1.0,
    };
    if divides {
        marked.iter().for_each(|&at| out[at] /= sum);
    }
    Ok(out)
}
