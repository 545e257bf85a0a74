//! A problem as JSON.

use super::definition::Problem;
use super::error::ProblemError;
use super::kinds::{WrittenInput, WrittenOutput, scalar_inputs, scalar_outputs};
use super::options::ProblemOptions;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: Option<String>,
    inputs: Option<Vec<WrittenInput>>,
    outputs: Option<Vec<WrittenOutput>>,
    sites: Rows,
    values: Option<Rows>,
    #[serde(default)]
    options: ProblemOptions,
}

/// Rows of numbers, or a column of them.
#[derive(Deserialize)]
#[serde(untagged)]
pub(in crate::kernel) enum Rows {
    Column(Vec<f64>),
    Rows(Vec<Vec<f64>>),
}

impl Rows {
    pub(in crate::kernel) fn rows(self) -> Vec<Vec<f64>> {
        match self {
            Self::Column(numbers) => numbers.into_iter().map(|number| vec![number]).collect(),
            Self::Rows(rows) => rows,
        }
    }
}

/// Reads a problem.
///
/// # Errors
/// [`ProblemError`] of JSON, kinds and rows.
pub(super) fn problem(text: &[u8], name: &str) -> Result<Problem, ProblemError> {
    let Written { name: own, inputs, outputs, sites, values, options } =
        serde_json::from_slice(text)?;
    let sites = sites.rows();
    let values = match values {
        Some(values) => values.rows(),
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
    Problem { name, inputs, outputs, sites, values, options }.check()
}

/// Makes values of n samples that are 1 at their own and 0 at the others.
fn weights(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|k| f64::from(u8::from(i == k))).collect()).collect()
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Queries {
    Named { queries: Rows },
    Bare(Rows),
}

/// Reads queries: `{"queries": [[...]]}`, or the rows alone.
///
/// # Errors
/// [`ProblemError::Json`].
pub(super) fn queries(text: &[u8]) -> Result<Vec<Vec<f64>>, ProblemError> {
    Ok(match serde_json::from_slice(text)? {
        Queries::Named { queries } | Queries::Bare(queries) => queries.rows(),
    })
}
