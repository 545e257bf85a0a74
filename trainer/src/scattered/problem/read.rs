//! Files of problems and of queries, by their ending.

use super::csv::{Table, column_names};
use super::definition::Problem;
use super::error::ProblemError;
use super::{json, npz};
use crate::formats::FormatError;
use crate::formats::extension::{extension, unknown_format};
use crate::scattered::model::Input;
use std::path::Path;

/// Reads a problem from JSON, CSV or `.npz`.
///
/// - `outputs`: names of a CSV's outputs; the last where none is named.
///
/// # Errors
/// [`ProblemError`]: of a file other than CSV also if outputs are named.
pub fn read(path: &Path, outputs: &[String]) -> Result<Problem, ProblemError> {
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    match extension(path).as_str() {
        "json" | "npz" if !outputs.is_empty() => Err(ProblemError::Outputs),
        "json" => json::problem(&bytes(path)?, &name),
        "csv" => Table::parse(&bytes(path)?)?.problem(&name, outputs),
        "npz" => npz::problem(path, &name),
        _ => Err(unknown_format(path, ".json, .csv or .npz").into()),
    }
}

/// Reads queries of a function from JSON or CSV: what is given of all inputs, a row a query.
///
/// # Errors
/// [`ProblemError`].
pub fn read_queries(path: &Path, inputs: &[Input]) -> Result<Vec<Vec<f64>>, ProblemError> {
    match extension(path).as_str() {
        "json" => json::queries(&bytes(path)?),
        "csv" => {
            let names: Vec<String> = inputs.iter().flat_map(column_names).collect();
            Table::parse(&bytes(path)?)?.columns(&names)
        }
        _ => Err(unknown_format(path, ".json or .csv").into()),
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, FormatError> {
    std::fs::read(path).map_err(FormatError::Read)
}
