//! Inputs of a function: the numbers that a user gives, and the features in which distances are measured.

use crate::Error;
use crate::regression::rotations::{Feature, Xyzw, from_euler};
use sinew_runtime::kernel::EulerOrder;

/// Named input.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Name of the input.
    pub name: String,
    /// Kind of the input.
    pub kind: InputKind,
    /// Factor of the input's distances.
    pub weight: f64,
}

/// Kind of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputKind {
    /// One number.
    Scalar,
    /// Three numbers of one unit.
    Vector3,
    /// Rotation.
    Rotation {
        /// Feature that the function uses.
        feature: Feature,
        /// Order of its Euler angles, in degrees; `None` for a quaternion x, y, z, w.
        order: Option<EulerOrder>,
    },
}

impl InputKind {
    /// Returns the number of values that a user gives.
    pub const fn given_len(self) -> usize {
        match self {
            Self::Rotation { order: Some(_), .. } => 3,
            kind => kind.number_len(),
        }
    }

    /// Returns the number of values in a file's function: a rotation is a quaternion there.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 => 3,
            Self::Rotation { .. } => 4,
        }
    }

    /// Returns the number of features.
    pub fn feature_len(self) -> usize {
        match self {
            Self::Rotation { feature, .. } => feature.number_len(),
            kind => kind.number_len(),
        }
    }

    /// Converts the given values into the values of a file's function.
    fn numbers(self, given: &[f64]) -> Vec<f64> {
        match (self, given) {
            (Self::Rotation { order: Some(order), .. }, &[x, y, z]) => {
                from_euler(order, [x, y, z]).to_vec()
            }
            _ => given.to_vec(),
        }
    }

    /// Computes the features.
    fn features(self, numbers: &[f64]) -> Result<Vec<f64>, Error> {
        match (self, numbers) {
            (Self::Rotation { feature, .. }, &[x, y, z, w]) => {
                let rotation: Xyzw = [x, y, z, w];
                feature.of(rotation)
            }
            _ => Ok(numbers.to_vec()),
        }
    }
}

/// Converts the given values of all inputs into the values of a file's function.
///
/// # Errors
/// If the number of values is wrong, or a value is not finite.
pub fn query_numbers(inputs: &[Input], given: &[f64]) -> Result<Vec<f64>, Error> {
    let expected: usize = inputs.iter().map(|input| input.kind.given_len()).sum();
    if given.len() != expected {
        let found = given.len();
        return Err(Error::mismatch(format!("expected {expected} numbers, found {found}")));
    }
    let mut out = Vec::new();
    let mut rest = given;
    for Input { name, kind, .. } in inputs {
        let own;
        let first = given.len() - rest.len();
        (own, rest) = rest.split_at(kind.given_len());
        if let Some(at) = own.iter().position(|x| !x.is_finite()) {
            let number = first + at;
            let message = format!("number {number} (input \"{name}\") is not finite");
            return Err(Error::value(message));
        }
        out.extend(kind.numbers(own));
    }
    Ok(out)
}

/// Computes the features of all inputs from the given values.
///
/// # Errors
/// Errors of [`query_numbers`]; if a quaternion is zero or not finite.
pub(crate) fn features(inputs: &[Input], given: &[f64]) -> Result<Vec<f64>, Error> {
    let numbers = query_numbers(inputs, given)?;
    let mut rest = numbers.as_slice();
    let mut out = Vec::new();
    for Input { name, kind, .. } in inputs {
        let own;
        (own, rest) = rest.split_at(kind.number_len());
        let named = |error: Error| error.within(format_args!("input \"{name}\""));
        out.extend(kind.features(own).map_err(named)?);
    }
    Ok(out)
}
