//! Outputs of a function, and their conversion from the values of a sum.

use crate::Error;
use crate::regression::rotations::{Xyzw, from_values, to_values};
use sinew_runtime::kernel::Normalise;

/// Least sum by which outputs are divided.
const LEAST_SUM: f64 = 1e-12;

/// Named output.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name of the output.
    pub name: String,
    /// Kind of the output.
    pub kind: OutputKind,
}

/// Kind of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutputKind {
    /// One number.
    Scalar {
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
        /// Whether the output belongs to those that are divided by their sum.
        normalised: bool,
        /// Value where the function has faded.
        neutral: f64,
    },
    /// Three numbers of one unit.
    Vector3 {
        /// Value where the function has faded.
        neutral: [f64; 3],
    },
    /// Quaternion x, y, z, w.
    Rotation {
        /// Rotation where the function has faded, of length 1. Rotations blend about it.
        neutral: Xyzw,
    },
}

impl OutputKind {
    /// A number without bounds, whose neutral value is 0.
    pub const FREE: Self = Self::Scalar {
        low: f32::MIN as f64,
        high: f32::MAX as f64,
        normalised: false,
        neutral: 0.0,
    };

    /// Returns the number of the function's values that the output uses.
    pub const fn value_len(self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Vector3 { .. } | Self::Rotation { .. } => 3,
        }
    }

    /// Returns the number of values of the output.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar { .. } => 1,
            Self::Vector3 { .. } => 3,
            Self::Rotation { .. } => 4,
        }
    }

    /// Converts a sample's numbers into values of the function.
    ///
    /// # Errors
    /// If a quaternion is no rotation.
    pub fn to_values(self, numbers: &[f64]) -> Result<Vec<f64>, Error> {
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

    /// Converts values of the function into numbers of the output.
    fn numbers(self, values: &[f64]) -> Result<Vec<f64>, Error> {
        match (self, values) {
            (Self::Scalar { low, high, .. }, &[value]) => Ok(vec![value.max(low).min(high)]),
            (Self::Rotation { neutral }, &[x, y, z]) => {
                Ok(from_values(neutral, [x, y, z])?.to_vec())
            }
            _ => Ok(values.to_vec()),
        }
    }
}

/// Computes the numbers of all outputs from a function's values.
///
/// # Errors
/// If a neutral quaternion is no rotation.
pub(super) fn output_numbers(
    outputs: &[Output],
    normalise: Normalise,
    values: &[f64],
) -> Result<Vec<f64>, Error> {
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
