//! Tables as CSV: a line of column names, then one row a line.

use super::extension::unmarked;
use crate::Error;
use std::fmt::Display;
use std::path::Path;

/// Characters that may separate cells, the most common first.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];
/// Line 1 is a title if the next line has more than this many times its cells.
const TITLE: usize = 2;

/// Columns of a take that hold no value of a curve, in lower case and without punctuation. A separator at the end of a
/// line makes a column without a name.
pub(crate) const NO_VALUES: [&str; 6] = ["timecode", "blendshapecount", "frame", TIME, "norm", ""];
/// Column of times, in seconds, in the same spelling.
pub(crate) const TIME: &str = "time";

/// A table of cells with named columns.
pub(crate) struct Table {
    /// Names of the columns.
    pub(crate) names: Vec<String>,
    /// Whether numbers may have a decimal comma: true unless commas separate cells.
    has_decimal_commas: bool,
    rows: Vec<Row>,
}

/// A row below the names, of any length.
pub(crate) struct Row {
    /// Line number, from 1.
    pub(crate) line: u64,
    cells: csv::StringRecord,
}

impl Row {
    /// Counts the cells.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }
}

/// Reads a file.
///
/// # Errors
/// The file cannot be read, and the errors of [`Table::parse`].
pub(crate) fn read(path: &Path) -> Result<Table, Error> {
    Table::parse(&std::fs::read(path).map_err(Error::read)?)
}

impl Table {
    /// Parses a table of UTF-8 text, with a line of names and at least one row.
    ///
    /// The separator is the one of [`SEPARATORS`] that the line of names has most of. Empty rows at the end are left
    /// out.
    ///
    /// # Errors
    /// The text is not UTF-8 or cannot be parsed, a line precedes the line of names, that line consists of numbers or
    /// repeats a name, or there is no row.
    pub(crate) fn parse(text: &[u8]) -> Result<Self, Error> {
        check_encoding(text)?;
        let text = unmarked(text);
        let separator = separator(text);
        let mut builder = csv::ReaderBuilder::new();
        let mut reader =
            builder.trim(csv::Trim::All).flexible(true).delimiter(separator).from_reader(text);
        let line_at = |at: Option<&csv::Position>| at.map_or(1, |position| line(text, position));
        let wrong =
            |error: csv::Error| unreadable(line_at(error.position()), &error).caused_by(error);
        let has_decimal_commas = separator != b',';
        let first = reader.headers().map_err(wrong)?.clone();
        let mut cells = first.iter().filter(|cell| !cell.is_empty()).peekable();
        if cells.peek().is_some() && cells.all(|cell| number(cell, has_decimal_commas).is_some()) {
            let found = first.iter().collect::<Vec<_>>().join(", ");
            return Err(no_names(line_at(first.position()), &found));
        }
        let mut names: Vec<String> = first.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            let cells = record.map_err(wrong)?;
            rows.push(Row { line: line_at(cells.position()), cells });
        }
        while rows.pop_if(|row| row.cells.iter().all(str::is_empty)).is_some() {}
        // A separator at the end of a line makes no further column.
        let has_cells =
            |at: usize| rows.iter().any(|row| row.cells.get(at).is_some_and(|x| !x.is_empty()));
        while names.last().is_some_and(String::is_empty) && !has_cells(names.len() - 1) {
            names.pop();
        }
        let table = Self { names, has_decimal_commas, rows };
        table.check()?;
        Ok(table)
    }

    /// Checks the names and that there is a row.
    fn check(&self) -> Result<(), Error> {
        let names = &self.names;
        let longer = self.rows.first().filter(|row| row.len() > names.len());
        let next = longer.map_or(0, |row| row.cells.iter().filter(|cell| !cell.is_empty()).count());
        if next > TITLE * names.iter().filter(|name| !name.is_empty()).count() {
            let found = names.join(" ");
            return Err(Error::damaged(format!(
                "line 1: expected the names of {next} columns, as the next line has, found {:?}: \
                 remove the lines before the names",
                found.trim()
            )));
        }
        let is_repeated = |&at: &usize| !names[at].is_empty() && names[..at].contains(&names[at]);
        if let Some(at) = (0..names.len()).find(is_repeated) {
            let name = &names[at];
            return Err(Error::value(format!("line 1: two columns are named {name:?}")));
        }
        match self.rows.is_empty() {
            true => Err(Error::missing("has no row below its line of names")),
            false => Ok(()),
        }
    }

    /// Returns the index of a column.
    ///
    /// # Errors
    /// No column has the name.
    pub(crate) fn column(&self, name: &str) -> Result<usize, Error> {
        let missing = || {
            let found = self.names.join(", ");
            Error::missing(format!("line 1: there is no column {name:?}; there are {found}"))
        };
        self.names.iter().position(|own| own == name).ok_or_else(missing)
    }

    /// Lists the rows.
    pub(crate) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Returns the text of a row's cell; `None` if the cell is empty or the row is too short.
    pub(crate) fn cell<'a>(&self, row: &'a Row, column: usize) -> Option<&'a str> {
        row.cells.get(column).filter(|cell| !cell.is_empty())
    }

    /// Parses a finite number in the notation of the table.
    pub(crate) fn number(&self, cell: &str) -> Option<f64> {
        number(cell, self.has_decimal_commas)
    }

    /// Parses the finite numbers of a row in the given columns.
    ///
    /// # Errors
    /// The row is shorter or longer than the line of names, or a cell is not a number.
    pub(crate) fn numbers_of(&self, row: &Row, columns: &[usize]) -> Result<Vec<f64>, Error> {
        let (expected, found) = (self.names.len(), row.len());
        let has_more = row.cells.iter().skip(expected).any(|cell| !cell.is_empty());
        if found < expected || has_more {
            let line = row.line;
            return Err(Error::mismatch(format!(
                "line {line}: expected {expected} columns, found {found}"
            )));
        }
        let read = |&column: &usize| {
            let cell = row.cells.get(column).unwrap_or_default();
            self.number(cell).ok_or_else(|| {
                let (line, name) = (row.line, &self.names[column]);
                Error::value(format!(
                    "line {line}, column {name:?}: expected a number, found {cell:?}"
                ))
            })
        };
        columns.iter().map(read).collect()
    }

    /// Parses the finite numbers of the given columns, row by row, each row with its line.
    ///
    /// # Errors
    /// The row is shorter or longer than the line of names, or a cell is not a number.
    pub(crate) fn numbers(
        &self,
        columns: &[usize],
    ) -> impl Iterator<Item = Result<(u64, Vec<f64>), Error>> {
        self.rows.iter().map(move |row| Ok((row.line, self.numbers_of(row, columns)?)))
    }
}

/// Checks that a text is UTF-8; the error names the encoding that the text seems to have.
fn check_encoding(text: &[u8]) -> Result<(), Error> {
    let start = &text[..text.len().min(4)];
    let is_wide = matches!(start, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) || start.contains(&0);
    let invalid = std::str::from_utf8(text).err().map(|error| error.valid_up_to());
    let (at, found) = match (is_wide, invalid) {
        (true, _) => (0, "UTF-16".to_owned()),
        (false, Some(at)) => (at, format!("byte {:#x}", text[at])),
        (false, None) => return Ok(()),
    };
    let line = 1 + text[..at].iter().filter(|byte| **byte == b'\n').count() as u64;
    let reason = format!("expected text in UTF-8, found {found}: save the table as CSV in UTF-8");
    Err(unreadable(line, reason))
}

/// Makes the error of a text that is not UTF-8, or cannot be parsed.
fn unreadable(line: u64, reason: impl Display) -> Error {
    Error::damaged(format!("line {line}: {reason}"))
}

/// Makes the error of a first line that consists of numbers instead of names.
pub(crate) fn no_names(line: u64, found: &str) -> Error {
    Error::missing(format!(
        "line {line}: expected the names of the columns, found numbers ({found}): write a line of \
         names above them"
    ))
}

/// Parses a finite number with a decimal comma or point.
///
/// If commas separate cells, a quoted "0,5" still has a decimal comma. A quoted "1,500" may mean 1500, so it is
/// refused.
fn number(cell: &str, has_decimal_commas: bool) -> Option<f64> {
    let decimals = cell.split_once(',').map(|(_, decimals)| decimals.len());
    let plain = match decimals {
        Some(3) if !has_decimal_commas => return None,
        Some(_) => cell.replacen(',', ".", 1).parse(),
        None => cell.parse(),
    };
    plain.ok().filter(|x: &f64| x.is_finite())
}

/// Returns the separator that is most frequent in the first line, outside quotes.
fn separator(text: &[u8]) -> u8 {
    let start = text.iter().position(|byte| !matches!(byte, b'\r' | b'\n')).unwrap_or_default();
    let mut counts = [0; SEPARATORS.len()];
    let mut is_quoted = false;
    for byte in text[start..].iter().take_while(|byte| !matches!(byte, b'\r' | b'\n')) {
        is_quoted ^= *byte == b'"';
        let found = SEPARATORS.iter().position(|separator| separator == byte);
        if let Some(at) = found.filter(|_| !is_quoted) {
            counts[at] += 1;
        }
    }
    let most = counts.into_iter().max().unwrap_or_default();
    let found = SEPARATORS.into_iter().zip(counts).find(|(_, count)| *count == most);
    found.map_or(b',', |(separator, _)| separator)
}

/// Returns the line of a row; the reader's position counts only up to the empty lines before the row.
fn line(text: &[u8], position: &csv::Position) -> u64 {
    let rest = text.get(position.byte() as usize..).unwrap_or_default();
    let empty = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    position.line() + empty.filter(|byte| **byte == b'\n').count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message_of(text: &str) -> String {
        let table = Table::parse(text.as_bytes());
        let all = table.and_then(|table| {
            let columns: Vec<usize> = (0..table.names.len()).collect();
            table.numbers(&columns).collect::<Result<Vec<_>, _>>()
        });
        all.map_or_else(|error| error.to_string(), |rows| format!("{rows:?}"))
    }

    #[test]
    fn rows_have_their_lines() {
        assert_eq!(
            message_of("\u{feff}a, b\n1, 2\n\n-3e1,4\n"),
            "[(2, [1.0, 2.0]), (4, [-30.0, 4.0])]"
        );
    }

    #[test]
    fn cells_are_separated_as_the_names_are() {
        let expected = "[(2, [1.5, -2.0]), (3, [3.0, 0.25])]";
        for text in [
            "a,b\n1.5,-2\n3,0.25\n",
            "a;b\n1,5;-2\n3;0,25\n",
            "a;b\n1.5;-2\n3;0.25\n",
            "a\tb\r\n1,5\t-2\r\n3\t0,25\r\n\r\n",
            "\u{feff}\"a\",\"b\"\n1.5,-2\n3,0.25\n,\n  \n",
            "\"a\";\"b\"\n1,5;-2\n3;0,25\n;\n",
        ] {
            assert_eq!(message_of(text), expected, "{text:?}");
        }
        let found = Table::parse(b"\"a, x, y\";b\n1;2\n").unwrap();
        assert_eq!(found.names, ["a, x, y", "b"]);
        // A number has at most one comma. If commas separate cells, a comma before three digits may separate thousands.
        assert_eq!(message_of("a,b\n\"1,5\",\"-2,0\"\n\"3,0\",\"0,25\"\n"), expected);
        assert!(message_of("a,b\n\"1,500\",2\n").contains("expected a number, found \"1,500\""));
        assert!(message_of("a;b\n1,234,5;2\n").contains("expected a number"));
    }

    #[test]
    fn a_line_of_names_comes_first() {
        let title = |found: &str| {
            format!(
                "line 1: expected the names of 3 columns, as the next line has, found {found:?}: \
             remove the lines before the names"
            )
        };
        for (text, expected) in [
            ("# exported\na,b,c\n1,2,3\n4\n", title("# exported")),
            ("sep=;\na;b;c\n1;2;3\n", title("sep=")),
            ("a,,\n1,2,3\n", "[(2, [1.0, 2.0, 3.0])]".to_owned()),
        ] {
            assert_eq!(message_of(text), expected, "{text:?}");
        }
    }

    #[test]
    fn separators_at_the_end_of_a_line_make_no_column() {
        let expected = "[(2, [1.0, 2.0]), (3, [3.0, 4.0])]";
        for text in ["a,b,\n1,2,\n3,4,\n", "a,b\n1,2,\n3,4,,\n", "a,b,,\n1,2\n3,4\n"] {
            assert_eq!(message_of(text), expected, "{text:?}");
        }
    }

    #[test]
    fn text_is_utf_8() {
        let text = "naïve,b\n1,2\n";
        let wide = |bytes: fn(u16) -> [u8; 2], mark: &str| -> Vec<u8> {
            format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
        };
        let latin = text.replace('ï', "?").into_bytes();
        let latin = latin.into_iter().map(|byte| if byte == b'?' { 0xef } else { byte }).collect();
        for (bytes, found) in [
            (wide(u16::to_le_bytes, "\u{feff}"), "UTF-16"),
            (wide(u16::to_be_bytes, "\u{feff}"), "UTF-16"),
            (wide(u16::to_le_bytes, ""), "UTF-16"),
            (latin, "byte 0xef"),
        ] {
            let said = Table::parse(&bytes).err().map(|error| error.to_string());
            let expected = format!(
                "line 1: expected text in UTF-8, found {found}: save the table as CSV in UTF-8"
            );
            assert_eq!(said, Some(expected));
        }
    }

    #[test]
    fn a_first_line_of_numbers_is_no_line_of_names() {
        for (text, line, found) in [
            ("30,0.25\n60,0.5\n", 1, "30, 0.25"),
            ("\n-1e3;0.5\n60;0,5\n", 2, "-1e3, 0.5"),
            ("1\n2\n", 1, "1"),
        ] {
            let expected = format!(
                "line {line}: expected the names of the columns, found numbers ({found}): write a line of \
             names above them"
            );
            assert_eq!(message_of(text), expected, "{text:?}");
        }
        assert_eq!(message_of("x,2\n1,2\n"), "[(2, [1.0, 2.0])]");
    }

    #[test]
    fn errors_name_the_line() {
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
            assert_eq!(message_of(text), expected, "{text:?}");
        }
        let table = Table::parse(b"a,b\n1,2\n").unwrap();
        let missing = table.column("frame").unwrap_err().to_string();
        assert_eq!(missing, "line 1: there is no column \"frame\"; there are a, b");
    }
}
