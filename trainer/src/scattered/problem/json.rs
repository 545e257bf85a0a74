//! Problems as JSON, with the kinds of inputs and outputs as a person writes them.

use super::definition::{Problem, ProblemOptions, wrong_rows};
use crate::Error;
use crate::formats::json;
use crate::regression::rotations::Feature;
use crate::scattered::model::{Input, InputKind, Output, OutputKind};
use serde::Deserialize;
use serde_json::Value;
use sinew_runtime::kernel::EulerOrder;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `sites` and `values`")]
struct Written {
    name: Option<String>,
    inputs: Option<Vec<WrittenInput>>,
    outputs: Option<Vec<WrittenOutput>>,
    sites: Value,
    values: Option<Value>,
    #[serde(default)]
    options: ProblemOptions,
}

/// Largest number of characters of a wrong value that an error shows.
const SHOWN: usize = 40;

/// Reads rows of numbers, or a column of numbers. All rows have the form of the first.
///
/// - `what`: name of the rows, for errors.
///
/// # Errors
/// If there are no rows, a row does not consist of numbers, or a row differs in form from the first.
pub(in crate::scattered) fn rows(what: &'static str, of: &Value) -> Result<Vec<Vec<f64>>, Error> {
    let Value::Array(all) = of else {
        let found = shown(of);
        return Err(Error::value(format!(
            "{what}: expected rows, as [[0, 1], [2, 3]], or a list of numbers, found {found}"
        )));
    };
    let is_column = all.first().is_some_and(Value::is_number);
    let row = |(row, own): (usize, &Value)| {
        let numbers = match own {
            Value::Number(number) if is_column => number.as_f64().map(|number| vec![number]),
            Value::Array(own) if !is_column => own.iter().map(Value::as_f64).collect(),
            _ => None,
        };
        let expected = if is_column { "a number, as in row 0" } else { "a list of numbers" };
        numbers.ok_or_else(|| {
            let found = shown(own);
            Error::value(format!("row {row} of {what}: expected {expected}, found {found}"))
        })
    };
    all.iter().enumerate().map(row).collect()
}

/// Formats a wrong value, shortened if it is long.
fn shown(found: &Value) -> String {
    let text = found.to_string();
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{} ...", &text[..end]),
        None => text,
    }
}

/// Reads a problem.
///
/// # Errors
/// If the text is not JSON of this form, a kind is unknown or lacks a part, or rows are wrong.
pub(super) fn problem(text: &[u8], name: &str) -> Result<Problem, Error> {
    let Written { name: own, inputs, outputs, sites, values, options } = json::read(text)?;
    let sites = rows("sites", &sites)?;
    let values = match values {
        Some(values) => rows("values", &values)?,
        None if options.weights => weights(sites.len()),
        None => return Err(wrong_rows(sites.len(), 0)),
    };
    let width = |rows: &[Vec<f64>]| rows.first().map_or(0, Vec::len);
    let inputs = match inputs {
        Some(inputs) => inputs.iter().map(WrittenInput::input).collect::<Result<_, _>>()?,
        None => scalar_inputs(width(&sites)),
    };
    let outputs = match outputs {
        Some(outputs) => outputs.iter().map(WrittenOutput::output).collect::<Result<_, _>>()?,
        None => scalar_outputs(width(&values)),
    };
    let name = own.unwrap_or_else(|| name.to_owned());
    Problem { name, inputs, outputs, sites, values, lines: Vec::new(), options }.check()
}

/// Makes the values of n weights: 1 at the sample of the weight and 0 at the others.
fn weights(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|k| f64::from(u8::from(i == k))).collect()).collect()
}

/// Reads queries: `{"queries": [[...]]}`, or the rows alone.
///
/// # Errors
/// If the text is not JSON; errors of [`rows`].
pub(super) fn queries(text: &[u8]) -> Result<Vec<Vec<f64>>, Error> {
    let all: Value = json::read(text)?;
    rows("queries", all.get("queries").unwrap_or(&all))
}

/// Kinds of inputs.
const INPUTS: &str = "scalar, vector3, quaternion, rows, swing, twist, angle or euler XYZ (any order), \
                      and \"swing euler XYZ\" likewise";
/// Kinds of outputs.
const OUTPUTS: &str = "scalar, vector3 or quaternion";

/// Input, as a person writes it.
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

/// Output, as a person writes it.
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
    /// Makes an input of a kind.
    pub(super) fn of(name: &str, kind: &str) -> Self {
        Self { name: name.to_owned(), kind: kind.to_owned(), weight: 1.0, axis: None }
    }

    /// Reads the kind of the input.
    ///
    /// # Errors
    /// If the kind is unknown, or the axis is missing, has length 0, or is not needed.
    pub(super) fn input(&self) -> Result<Input, Error> {
        let Self { name, kind: written, weight, axis } = self;
        let words: Vec<&str> = written.split_whitespace().collect();
        let order = |word: &str| {
            EulerOrder::ALL.into_iter().find(|order| order.name().eq_ignore_ascii_case(word))
        };
        let (feature, order) = match words[..] {
            ["scalar"] | ["vector3"] => (None, None),
            ["euler", word] => (Some("quaternion"), order(word)),
            [feature, "euler", word] => (Some(feature), order(word)),
            [feature] => (Some(feature), None),
            _ => (Some(""), None),
        };
        let unknown = || wrong_kind("input", name, INPUTS, written);
        let wrong_axis = |what: &str| Error::value(format!("input \"{name}\": {what}"));
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
        let about = || about().map_err(wrong_axis);
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
            return Err(wrong_axis("it has an axis, which only swing, twist and angle have"));
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
    /// Makes an output of a kind.
    pub(super) fn of(name: &str, kind: &str) -> Self {
        Self { name: name.to_owned(), kind: kind.to_owned(), clamp: None, normalise: false }
    }

    /// Reads the kind of the output. Its neutral value is 0, or the identity, until the neutral sample sets it.
    ///
    /// # Errors
    /// If the kind is unknown, the bounds are reversed, or an output of several numbers has bounds.
    pub(super) fn output(&self) -> Result<Output, Error> {
        let Self { name, kind, clamp, normalise } = self;
        let [low, high] = clamp.unwrap_or_default();
        let [low, high] = [low.unwrap_or(f64::from(f32::MIN)), high.unwrap_or(f64::from(f32::MAX))];
        let wrong = |what: &str| Err(Error::value(format!("output \"{name}\": {what}")));
        let kind = match kind.as_str() {
            "scalar" if low <= high => {
                OutputKind::Scalar { low, high, normalised: *normalise, neutral: 0.0 }
            }
            "scalar" => return wrong("its bounds are the wrong way round"),
            "vector3" => OutputKind::Vector3 { neutral: [0.0; 3] },
            "quaternion" => OutputKind::Rotation { neutral: [0.0, 0.0, 0.0, 1.0] },
            found => return Err(wrong_kind("output", name, OUTPUTS, found)),
        };
        if kind.value_len() > 1 && (clamp.is_some() || *normalise) {
            return wrong("only a scalar has bounds or a share of a sum");
        }
        Ok(Output { name: name.clone(), kind })
    }
}

/// Returns the error of an input or output whose kind is unknown.
pub(super) fn wrong_kind(what: &str, name: &str, expected: &str, found: &str) -> Error {
    Error::value(format!("{what} \"{name}\": expected {expected}, found \"{found}\""))
}

/// Makes scalar inputs with default names.
pub(super) fn scalar_inputs(len: usize) -> Vec<Input> {
    let input = |i| Input { name: format!("x{i}"), kind: InputKind::Scalar, weight: 1.0 };
    (0..len).map(input).collect()
}

/// Makes scalar outputs with default names.
pub(super) fn scalar_outputs(len: usize) -> Vec<Output> {
    (0..len).map(|i| Output { name: format!("y{i}"), kind: OutputKind::FREE }).collect()
}
