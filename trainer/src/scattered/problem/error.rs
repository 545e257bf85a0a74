//! Errors of reading a problem.

use crate::formats::{CsvError, FormatError, JsonError};

/// Reasons why a problem cannot be read; rows count from 0.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// The file cannot be read, or has another format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The text is not JSON of this form.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A column of a CSV has cells but no name.
    #[error("line 1: column {column} has no name: give it one, or take the column away")]
    Unnamed {
        /// Number of the column, from 1.
        column: usize,
    },
    /// `--outputs` was given for a file other than CSV.
    #[error(
        "--outputs names columns of a CSV: a .json has its own `outputs`, a .npz has its `values`"
    )]
    Outputs,
    /// Two inputs, or two outputs, have the same name.
    #[error("two {what} are named \"{name}\"")]
    Twice {
        /// Inputs or outputs.
        what: &'static str,
        /// The common name.
        name: String,
    },
    /// There are no samples.
    #[error("there are no samples")]
    Empty,
    /// The numbers of sites and values differ.
    #[error("expected a row of values for each of {sites} sites, found {values}")]
    Rows {
        /// Number of sites.
        sites: usize,
        /// Number of rows of values.
        values: usize,
    },
    /// There are no rows.
    #[error("{what}: expected rows, as [[0, 1], [2, 3]], or a list of numbers, found {found}")]
    NoRows {
        /// Sites, values or queries.
        what: &'static str,
        /// Text that was found.
        found: String,
    },
    /// A row does not consist of numbers, or differs in form from the first row.
    #[error("row {row} of {what}: expected {expected}, found {found}")]
    Entry {
        /// Sites, values or queries.
        what: &'static str,
        /// Index of the row.
        row: usize,
        /// Expected form.
        expected: &'static str,
        /// Text that was found.
        found: String,
    },
    /// A row has too few or too many numbers.
    #[error("row {row} of {what}: expected {expected} numbers, found {found}")]
    Row {
        /// Sites or values.
        what: &'static str,
        /// Index of the row.
        row: usize,
        /// Number of values of all inputs or outputs.
        expected: usize,
        /// Number of values in the row.
        found: usize,
    },
    /// The kind is unknown.
    #[error("{what} \"{name}\": expected {expected}, found \"{found}\"")]
    Kind {
        /// Input or output.
        what: &'static str,
        /// Name of the input or output.
        name: String,
        /// Known kinds.
        expected: &'static str,
        /// Kind that was written.
        found: String,
    },
    /// An input has no axis and needs one, has an axis and needs none, or has an axis of length 0.
    #[error("input \"{name}\": {what}")]
    Axis {
        /// Name of the input.
        name: String,
        /// Description of the error.
        what: &'static str,
    },
    /// An output's bounds are reversed, or the output is not a number.
    #[error("output \"{name}\": {what}")]
    Bounds {
        /// Name of the output.
        name: String,
        /// Description of the error.
        what: &'static str,
    },
    /// The named column does not exist.
    #[error("there is no column \"{name}\"; there are {found}")]
    Column {
        /// Name of the column.
        name: String,
        /// Names of the existing columns.
        found: String,
    },
    /// The options allow no fit.
    #[error("{0}")]
    Options(String),
}

impl From<CsvError> for ProblemError {
    fn from(error: CsvError) -> Self {
        Self::Format(error.into())
    }
}
