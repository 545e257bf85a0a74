//! A problem as JSON.

use super::definition::Problem;
use super::error::ProblemError;
use super::kinds::{WrittenInput, WrittenOutput, scalar_inputs, scalar_outputs};
use super::options::ProblemOptions;
use crate::formats::json;
use serde::Deserialize;
use serde_json::Value;

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

/// Most characters of a wrong value that an error shows.
const SHOWN: usize = 40;

/// Reads rows of numbers, or a column of them; all rows of one kind.
///
/// - `what`: the name of the rows, for errors.
///
/// # Errors
/// [`ProblemError::NoRows`] and [`ProblemError::Entry`].
pub(in crate::scattered) fn rows(
    what: &'static str,
    of: &Value,
) -> Result<Vec<Vec<f64>>, ProblemError> {
    let Value::Array(all) = of else {
        return Err(ProblemError::NoRows { what, found: shown(of) });
    };
    let is_column = all.first().is_some_and(Value::is_number);
    let row = |(row, own): (usize, &Value)| {
        let numbers = match own {
            Value::Number(number) if is_column => number.as_f64().map(|number| vec![number]),
            Value::Array(own) if !is_column => own.iter().map(Value::as_f64).collect(),
            _ => None,
        };
        let expected = if is_column { "a number, as in row 0" } else { "a list of numbers" };
        numbers.ok_or_else(|| ProblemError::Entry { what, row, expected, found: shown(own) })
    };
    all.iter().enumerate().map(row).collect()
}

/// Writes a wrong value, its beginning if it is long.
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
/// [`ProblemError`] of JSON, kinds and rows.
pub(super) fn problem(text: &[u8], name: &str) -> Result<Problem, ProblemError> {
    let Written { name: own, inputs, outputs, sites, values, options } = json::read(text)?;
    let sites = rows("sites", &sites)?;
    let values = match values {
        Some(values) => rows("values", &values)?,
        None if options.weights => weights(sites.len()),
        None => return Err(ProblemError::Rows { sites: sites.len(), values: 0 }),
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

/// Makes values of n samples that are 1 at their own and 0 at the others.
fn weights(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|k| f64::from(u8::from(i == k))).collect()).collect()
}

/// Reads queries: `{"queries": [[...]]}`, or the rows alone.
///
/// # Errors
/// [`ProblemError::Json`], and those of [`rows`].
pub(super) fn queries(text: &[u8]) -> Result<Vec<Vec<f64>>, ProblemError> {
    let all: Value = json::read(text)?;
    rows("queries", all.get("queries").unwrap_or(&all))
}
