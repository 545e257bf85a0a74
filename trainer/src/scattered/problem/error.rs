//! Why a problem cannot be read.

use crate::formats::{CsvError, FormatError, JsonError};

/// A problem that cannot be read; rows count from 0.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// The file cannot be read, or is no such file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// It is no JSON of this shape.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A column of a CSV has cells and no name.
    #[error("line 1: column {column} has no name: give it one, or take the column away")]
    Unnamed {
        /// The column, from 1.
        column: usize,
    },
    /// `--outputs` was given with a file other than CSV.
    #[error(
        "--outputs names columns of a CSV: a .json has its own `outputs`, a .npz has its `values`"
    )]
    Outputs,
    /// Two inputs, or two outputs, have one name.
    #[error("two {what} are named \"{name}\"")]
    Twice {
        /// Inputs or outputs.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// There are no samples.
    #[error("there are no samples")]
    Empty,
    /// Sites and values are not as many.
    #[error("expected a row of values for each of {sites} sites, found {values}")]
    Rows {
        /// Rows of the sites.
        sites: usize,
        /// Rows of the values.
        values: usize,
    },
    /// There are no rows.
    #[error("{what}: expected rows, as [[0, 1], [2, 3]], or a list of numbers, found {found}")]
    NoRows {
        /// Sites, values or queries.
        what: &'static str,
        /// What there is.
        found: String,
    },
    /// A row is none of numbers, or unlike the first.
    #[error("row {row} of {what}: expected {expected}, found {found}")]
    Entry {
        /// Sites, values or queries.
        what: &'static str,
        /// Which row.
        row: usize,
        /// What it should be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A row is too short or too long.
    #[error("row {row} of {what}: expected {expected} numbers, found {found}")]
    Row {
        /// Sites or values.
        what: &'static str,
        /// Which row.
        row: usize,
        /// As many as inputs or outputs have.
        expected: usize,
        /// As many as there are.
        found: usize,
    },
    /// A kind is unknown.
    #[error("{what} \"{name}\": expected {expected}, found \"{found}\"")]
    Kind {
        /// Input or output.
        what: &'static str,
        /// Its name.
        name: String,
        /// What there is.
        expected: &'static str,
        /// What was written.
        found: String,
    },
    /// An input needs an axis that it has not, or has one that it does not need, or of no length.
    #[error("input \"{name}\": {what}")]
    Axis {
        /// Its name.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// An output's bounds are the wrong way round, or belong to no number.
    #[error("output \"{name}\": {what}")]
    Bounds {
        /// Its name.
        name: String,
        /// What is wrong.
        what: &'static str,
    },
    /// A column that was asked for is not there.
    #[error("there is no column \"{name}\"; there are {found}")]
    Column {
        /// Its name.
        name: String,
        /// Those that there are.
        found: String,
    },
    /// No fit can be made so.
    #[error("{0}")]
    Options(String),
}

impl From<CsvError> for ProblemError {
    fn from(error: CsvError) -> Self {
        Self::Format(error.into())
    }
}
