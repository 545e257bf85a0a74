//! Tables as CSV: a line of names, then a row a line.

use super::error::FormatError;
use std::path::Path;

/// A table that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// It is no text, or its quotes do not close.
    #[error("line {line}: {reason}")]
    Text {
        /// The line, the first being 1.
        line: u64,
        /// What the reader says.
        reason: String,
    },
    /// Two columns have one name.
    #[error("line 1: two columns are named {name:?}")]
    Twice {
        /// The name.
        name: String,
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

/// A table of cells with named columns.
pub(crate) struct Table {
    /// Names of the columns.
    pub(crate) names: Vec<String>,
    rows: Vec<(u64, csv::StringRecord)>,
}

/// Reads a file.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::Csv`].
pub(crate) fn read(path: &Path) -> Result<Table, FormatError> {
    let text = std::fs::read(path).map_err(FormatError::Read)?;
    Ok(Table::parse(&text)?)
}

impl Table {
    /// Reads a table, of at least one row.
    ///
    /// # Errors
    /// A [`CsvError`], but for those of numbers.
    pub(crate) fn parse(text: &[u8]) -> Result<Self, CsvError> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text);
        let wrong = |error: csv::Error| {
            let line = error.position().map_or(1, csv::Position::line);
            CsvError::Text { line, reason: error.to_string() }
        };
        let head = reader.headers().map_err(wrong)?;
        let names: Vec<String> =
            head.iter().map(|name| name.trim_start_matches('\u{feff}').to_owned()).collect();
        if let Some(at) = (0..names.len()).find(|&at| names[..at].contains(&names[at])) {
            return Err(CsvError::Twice { name: names[at].clone() });
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let line = record.position().map_or(1, csv::Position::line);
            let (expected, found) = (names.len(), record.len());
            if found != expected {
                return Err(CsvError::Row { line, expected, found });
            }
            rows.push((line, record));
        }
        if rows.is_empty() { Err(CsvError::Empty) } else { Ok(Self { names, rows }) }
    }

    /// Finds a column.
    ///
    /// # Errors
    /// [`CsvError::Missing`]
    pub(crate) fn column(&self, name: &str) -> Result<usize, CsvError> {
        let found = self.names.join(", ");
        let missing = || CsvError::Missing { name: name.to_owned(), found };
        self.names.iter().position(|own| own == name).ok_or_else(missing)
    }

    /// Gives the finite numbers of some columns, row by row, each row with its line.
    ///
    /// # Errors
    /// [`CsvError::Number`]
    pub(crate) fn numbers(
        &self,
        columns: &[usize],
    ) -> impl Iterator<Item = Result<(u64, Vec<f64>), CsvError>> {
        self.rows.iter().map(move |(line, cells)| {
            let number = |&column: &usize| {
                let cell = cells.get(column).unwrap_or_default();
                cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| CsvError::Number {
                    line: *line,
                    column: self.names[column].clone(),
                    found: cell.to_owned(),
                })
            };
            Ok((*line, columns.iter().map(number).collect::<Result<_, _>>()?))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        let table = Table::parse(text.as_bytes());
        let all = table.and_then(|table| {
            let columns: Vec<usize> = (0..table.names.len()).collect();
            table.numbers(&columns).collect::<Result<Vec<_>, _>>()
        });
        all.map_or_else(|error| error.to_string(), |rows| format!("{rows:?}"))
    }

    #[test]
    fn rows_have_their_lines() {
        assert_eq!(said("\u{feff}a, b\n1, 2\n\n-3e1,4\n"), "[(2, [1.0, 2.0]), (4, [-30.0, 4.0])]");
    }

    #[test]
    fn what_is_wrong_is_named_by_line() {
        for (text, expected) in [
            ("a,b\n1,2\n3\n", "line 3: expected 2 columns, found 1"),
            ("a,b\n1,2,3\n", "line 2: expected 2 columns, found 3"),
            ("a,b\n1,2\n1,x\n", "line 3, column \"b\": expected a number, found \"x\""),
            ("a,b\n1,\n", "line 2, column \"b\": expected a number, found \"\""),
            ("a,b\nnan,1\n", "line 2, column \"a\": expected a number, found \"nan\""),
            ("a,a\n1,2\n", "line 1: two columns are named \"a\""),
            ("a,b\n", "has no row below its line of names"),
            ("", "has no row below its line of names"),
        ] {
            assert_eq!(said(text), expected, "{text:?}");
        }
        let table = Table::parse(b"a,b\n1,2\n").unwrap();
        let missing = table.column("frame").unwrap_err().to_string();
        assert_eq!(missing, "line 1: there is no column \"frame\"; there are a, b");
    }
}
