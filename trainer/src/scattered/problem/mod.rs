//! Problems: samples of a function from named inputs to named outputs, as a person writes them in JSON, CSV or `.npz`.

mod csv;
mod definition;
mod json;

pub use definition::{Learn, LearnMethod, Mode, Problem, ProblemOptions, Smoothing};
pub(super) use json::rows;

use crate::Error;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::npz::Archive;
use crate::scattered::model::Input;
use csv::{Table, column_names};
use json::{scalar_inputs, scalar_outputs};
use std::path::Path;

/// Reads a problem from JSON, CSV or `.npz`.
///
/// - `outputs`: names of a CSV's outputs; empty for the last column.
///
/// # Errors
/// If the file cannot be read or has another format, its contents do not form a problem, or outputs are named for a
/// file other than CSV.
pub fn read(path: &Path, outputs: &[String]) -> Result<Problem, Error> {
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    match extension(path).as_str() {
        "json" | "npz" if !outputs.is_empty() => Err(Error::unsupported(
            "--outputs names columns of a CSV: a .json has its own `outputs`, a .npz has its `values`",
        )),
        "json" => json::problem(&bytes(path)?, &name),
        "csv" => Table::parse(&bytes(path)?)?.problem(&name, outputs),
        "npz" => from_npz(path, &name),
        _ => Err(unknown_format(path, ".json, .csv or .npz")),
    }
}

/// Reads queries of a function from JSON or CSV: the given numbers of all inputs, a row a query.
///
/// # Errors
/// If the file cannot be read or has another format, or its contents are not rows of numbers.
pub fn read_queries(path: &Path, inputs: &[Input]) -> Result<Vec<Vec<f64>>, Error> {
    match extension(path).as_str() {
        "json" => json::queries(&bytes(path)?),
        "csv" => {
            let names: Vec<String> = inputs.iter().flat_map(column_names).collect();
            Table::parse(&bytes(path)?)?.columns(&names)
        }
        _ => Err(unknown_format(path, ".json or .csv")),
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(Error::read)
}

/// Reads a problem of scalars from the arrays `sites`, n x d, and `values`, n x m.
///
/// # Errors
/// If an array is missing or damaged; errors of [`Problem::check`].
fn from_npz(path: &Path, name: &str) -> Result<Problem, Error> {
    let mut archive = Archive::open(path)?;
    let mut matrix = |array| -> Result<Vec<Vec<f64>>, Error> {
        let rows = archive.required::<f64, 1>(array, &[0])?;
        let width = rows.lead.get(1).copied().unwrap_or(0).max(1);
        Ok(rows.data.as_flattened().chunks(width).map(<[f64]>::to_vec).collect())
    };
    let (sites, values) = (matrix("sites")?, matrix("values")?);
    let width = |rows: &[Vec<f64>]| rows.first().map_or(0, Vec::len);
    Problem {
        name: name.to_owned(),
        inputs: scalar_inputs(width(&sites)),
        outputs: scalar_outputs(width(&values)),
        sites,
        values,
        lines: Vec::new(),
        options: ProblemOptions::default(),
    }
    .check()
}
