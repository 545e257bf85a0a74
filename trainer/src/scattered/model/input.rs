//! Inputs of a function: numbers as they are given, and the features that distances are measured in.

use crate::regression::rotations::{Feature, RotationError, Xyzw, from_euler};
use sinew_runtime::kernel::EulerOrder;

/// A named input.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: InputKind,
    /// How much it counts in distances.
    pub weight: f64,
}

/// What an input is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputKind {
    /// A number.
    Scalar,
    /// Three numbers of one unit.
    Vector3,
    /// A rotation.
    Rotation {
        /// What the function is given of it.
        feature: Feature,
        /// The order of its angles in degrees, where it is given so; else it is a quaternion, x, y, z, w.
        order: Option<EulerOrder>,
    },
}

/// Numbers that a function cannot be evaluated at.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EvaluationError {
    /// There are too few or too many.
    #[error("expected {expected} numbers, found {found}")]
    Length {
        /// As many as all inputs have.
        expected: usize,
        /// As many as there are.
        found: usize,
    },
    /// A number is not finite.
    #[error("number {number} (input \"{input}\") is not finite")]
    NotFinite {
        /// Its place.
        number: usize,
        /// The input's name.
        input: String,
    },
    /// A rotation is none.
    #[error("input \"{input}\": {error}")]
    Rotation {
        /// The input's name.
        input: String,
        /// Why.
        error: RotationError,
    },
}

impl InputKind {
    /// Returns how many numbers it is given as.
    pub const fn given_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 | Self::Rotation { order: Some(_), .. } => 3,
            Self::Rotation { order: None, .. } => 4,
        }
    }

    /// Returns how many numbers a file's function takes for it: a rotation is a quaternion there.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 => 3,
            Self::Rotation { .. } => 4,
        }
    }

    /// Returns how many features it has.
    pub fn feature_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 => 3,
            Self::Rotation { feature, .. } => feature.number_len(),
        }
    }

    /// Turns what is given to what a file's function takes.
    fn numbers(self, given: &[f64]) -> Vec<f64> {
        match (self, given) {
            (Self::Rotation { order: Some(order), .. }, &[x, y, z]) => {
                from_euler(order, [x, y, z]).to_vec()
            }
            _ => given.to_vec(),
        }
    }

    /// Computes its features.
    fn features(self, numbers: &[f64]) -> Result<Vec<f64>, RotationError> {
        match (self, numbers) {
            (Self::Rotation { feature, .. }, &[x, y, z, w]) => {
                let rotation: Xyzw = [x, y, z, w];
                feature.of(rotation)
            }
            _ => Ok(numbers.to_vec()),
        }
    }
}

/// Turns what is given of all inputs to the numbers that a file's function takes.
///
/// # Errors
/// [`EvaluationError::Length`] and [`EvaluationError::NotFinite`].
pub fn query_numbers(inputs: &[Input], given: &[f64]) -> Result<Vec<f64>, EvaluationError> {
    let expected = inputs.iter().map(|input| input.kind.given_len()).sum();
    if given.len() != expected {
        return Err(EvaluationError::Length { expected, found: given.len() });
    }
    let mut out = Vec::new();
    let mut rest = given;
    for Input { name, kind, .. } in inputs {
        let own;
        let first = given.len() - rest.len();
        (own, rest) = rest.split_at(kind.given_len());
        if let Some(at) = own.iter().position(|x| !x.is_finite()) {
            return Err(EvaluationError::NotFinite { number: first + at, input: name.clone() });
        }
        out.extend(kind.numbers(own));
    }
    Ok(out)
}

/// Computes the features of all inputs from what is given of them.
///
/// # Errors
/// [`EvaluationError`].
pub(crate) fn features(inputs: &[Input], given: &[f64]) -> Result<Vec<f64>, EvaluationError> {
    let numbers = query_numbers(inputs, given)?;
    let mut rest = numbers.as_slice();
    let mut out = Vec::new();
    for Input { name, kind, .. } in inputs {
        let own;
        (own, rest) = rest.split_at(kind.number_len());
        let rotation = |error| EvaluationError::Rotation { input: name.clone(), error };
        out.extend(kind.features(own).map_err(rotation)?);
    }
    Ok(out)
}
