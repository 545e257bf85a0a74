//! What can be wrong with a table.

/// A table that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// It is no text in UTF-8.
    #[error("line {line}: {reason}")]
    Text {
        /// The line, the first being 1.
        line: u64,
        /// What the reader says.
        reason: String,
    },
    /// The first line is of numbers, all or most of it.
    #[error(
        "line {line}: expected the names of the columns, found numbers ({found}): write a line of names above \
         them"
    )]
    NoNames {
        /// The line, the first being 1.
        line: u64,
        /// The numbers, or the first.
        found: String,
    },
    /// Two columns have one name.
    #[error("line 1: two columns are named {name:?}")]
    Twice {
        /// The name.
        name: String,
    },
    /// A line stands before that of the names.
    #[error(
        "line 1: expected the names of {expected} columns, as the next line has, found {found:?}: \
         remove the lines before the names"
    )]
    Title {
        /// Columns of the next line.
        expected: usize,
        /// The text of the line.
        found: String,
    },
    /// A column that is needed is absent.
    #[error("line 1: there is no column {name:?}; there are {found}")]
    Missing {
        /// Its name.
        name: String,
        /// Those that there are.
        found: String,
    },
    /// A row is shorter or longer than the line of names.
    #[error("line {line}: expected {expected} columns, found {found}")]
    Row {
        /// The line, the first being 1.
        line: u64,
        /// Columns that have names.
        expected: usize,
        /// Columns of the line.
        found: usize,
    },
    /// A cell is no number.
    #[error("line {line}, column {column:?}: expected a number, found {found:?}")]
    Number {
        /// The line, the first being 1.
        line: u64,
        /// The column's name.
        column: String,
        /// What is there.
        found: String,
    },
    /// There is no row.
    #[error("has no row below its line of names")]
    Empty,
}
