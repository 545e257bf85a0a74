//! Kinds of inputs and outputs, as they are written.

use super::error::ProblemError;
use crate::regression::rotations::Feature;
use crate::scattered::model::{Input, InputKind, Output, OutputKind};
use serde::Deserialize;
use sinew_runtime::kernel::EulerOrder;

/// The orders of Euler angles, by name.
const ORDERS: [(&str, EulerOrder); 6] = [
    ("XYZ", EulerOrder::Xyz),
    ("XZY", EulerOrder::Xzy),
    ("YXZ", EulerOrder::Yxz),
    ("YZX", EulerOrder::Yzx),
    ("ZXY", EulerOrder::Zxy),
    ("ZYX", EulerOrder::Zyx),
];
/// What an input may be.
const INPUTS: &str = "scalar, vector3, quaternion, rows, swing, twist, angle or euler XYZ (any order), \
                      and \"swing euler XYZ\" likewise";
/// What an output may be.
const OUTPUTS: &str = "scalar, vector3 or quaternion";

/// An input as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an input, as {\"name\": \"x\"}")]
pub(super) struct WrittenInput {
    name: String,
    #[serde(default = "scalar")]
    kind: String,
    #[serde(default = "one")]
    weight: f64,
    axis: Option<[f64; 3]>,
}

/// An output as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an output, as {\"name\": \"y\"}")]
pub(super) struct WrittenOutput {
    name: String,
    #[serde(default = "scalar")]
    kind: String,
    clamp: Option<[Option<f64>; 2]>,
    #[serde(default)]
    normalise: bool,
}

fn scalar() -> String {
    "scalar".to_owned()
}

const fn one() -> f64 {
    1.0
}

impl WrittenInput {
    /// # Errors
    /// [`ProblemError::Kind`] and [`ProblemError::Axis`].
    pub(super) fn input(&self) -> Result<Input, ProblemError> {
        let Self { name, kind: written, weight, axis } = self;
        let words: Vec<&str> = written.split_whitespace().collect();
        let order = |word: &str| {
            ORDERS.iter().find(|(name, _)| name.eq_ignore_ascii_case(word)).map(|(_, order)| *order)
        };
        let (feature, order) = match words[..] {
            ["scalar"] | ["vector3"] => (None, None),
            ["euler", word] => (Some("quaternion"), order(word)),
            [feature, "euler", word] => (Some(feature), order(word)),
            [feature] => (Some(feature), None),
            _ => (Some(""), None),
        };
        let unknown = || ProblemError::Kind {
            what: "input",
            name: name.clone(),
            expected: INPUTS,
            found: written.clone(),
        };
        if words.contains(&"euler") && order.is_none() {
            return Err(unknown());
        }
        let about = || {
            let axis = axis.ok_or("its axis is missing")?;
            let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
            let axis = axis.map(|x| x / length);
            if axis.iter().all(|x| x.is_finite()) {
                Ok(axis)
            } else {
                Err("its axis has no length")
            }
        };
        let about = || about().map_err(|what| ProblemError::Axis { name: name.clone(), what });
        let feature = match feature {
            None => None,
            Some("quaternion") => Some(Feature::Matrix),
            Some("rows") => Some(Feature::TwoRows),
            Some("swing") => Some(Feature::Swing(about()?)),
            Some("twist") => Some(Feature::Twist(about()?)),
            Some("angle") => Some(Feature::TwistAngle(about()?)),
            Some(_) => return Err(unknown()),
        };
        let has_axis = !matches!(feature, None | Some(Feature::Matrix | Feature::TwoRows));
        if axis.is_some() && !has_axis {
            let what = "it has an axis, which only swing, twist and angle have";
            return Err(ProblemError::Axis { name: name.clone(), what });
        }
        let kind = match feature {
            Some(feature) => InputKind::Rotation { feature, order },
            None if written.trim() == "vector3" => InputKind::Vector3,
            None => InputKind::Scalar,
        };
        Ok(Input { name: name.clone(), kind, weight: *weight })
    }
}

impl WrittenOutput {
    /// Its neutral is 0, or no rotation, until a sample is known.
    ///
    /// # Errors
    /// [`ProblemError::Kind`] and [`ProblemError::Bounds`].
    pub(super) fn output(&self) -> Result<Output, ProblemError> {
        let Self { name, kind, clamp, normalise } = self;
        let [low, high] = clamp.unwrap_or_default();
        let [low, high] = [low.unwrap_or(f64::from(f32::MIN)), high.unwrap_or(f64::from(f32::MAX))];
        let wrong = |what| Err(ProblemError::Bounds { name: name.clone(), what });
        let kind = match kind.as_str() {
            "scalar" if low <= high => {
                OutputKind::Scalar { low, high, normalised: *normalise, neutral: 0.0 }
            }
            "scalar" => return wrong("its bounds are the wrong way round"),
            "vector3" => OutputKind::Vector3 { neutral: [0.0; 3] },
            "quaternion" => OutputKind::Rotation { neutral: [0.0, 0.0, 0.0, 1.0] },
            found => {
                return Err(ProblemError::Kind {
                    what: "output",
                    name: name.clone(),
                    expected: OUTPUTS,
                    found: found.to_owned(),
                });
            }
        };
        if kind.value_len() > 1 && (clamp.is_some() || *normalise) {
            return wrong("only a scalar has bounds or a share of a sum");
        }
        Ok(Output { name: name.clone(), kind })
    }
}

/// Makes so many scalar inputs that nobody has named.
pub(super) fn scalar_inputs(len: usize) -> Vec<Input> {
    let input = |i| Input { name: format!("x{i}"), kind: InputKind::Scalar, weight: 1.0 };
    (0..len).map(input).collect()
}

/// Makes so many scalar outputs that nobody has named.
pub(super) fn scalar_outputs(len: usize) -> Vec<Output> {
    (0..len).map(|i| Output { name: format!("y{i}"), kind: free_scalar() }).collect()
}

/// Returns the kind of a scalar without bounds.
pub(super) fn free_scalar() -> OutputKind {
    let [low, high] = [f32::MIN, f32::MAX].map(f64::from);
    OutputKind::Scalar { low, high, normalised: false, neutral: 0.0 }
}
