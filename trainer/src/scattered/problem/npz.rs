//! A problem as `.npz`: arrays `sites`, n x d, and `values`, n x m, of numbers.

use super::definition::Problem;
use super::error::ProblemError;
use super::kinds::{scalar_inputs, scalar_outputs};
use super::options::ProblemOptions;
use crate::formats::npz::Archive;
use std::path::Path;

/// Reads a problem of scalars.
///
/// # Errors
/// [`ProblemError::Format`], and those of rows.
pub(super) fn problem(path: &Path, name: &str) -> Result<Problem, ProblemError> {
    let mut archive = Archive::open(path)?;
    let mut matrix = |array| -> Result<Vec<Vec<f64>>, ProblemError> {
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
