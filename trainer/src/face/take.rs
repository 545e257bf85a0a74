//! Takes: weights of a face's shapes, frame by frame.

use super::basis::not_finite;
use super::names::{Columns, is_count};
use super::source::count;
use crate::Error;
use crate::formats::csv;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::npz::Archive;
use std::ops::Range;
use std::path::Path;

/// Weights of S shapes over N frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Take {
    /// Weights, N x S; 0 for shapes without a column.
    pub frames: Vec<Vec<f64>>,
    /// Row number of each frame in the file, from 0, ascending, N.
    pub numbers: Vec<usize>,
    /// Lines without tracking, which give no frame.
    pub lost: Vec<u64>,
    /// Names of expressions and angles without a shape.
    pub skipped: Vec<String>,
    /// The weight of the largest magnitude; `None` if all are 0.
    pub largest: Option<Largest>,
}

/// The largest weight of a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Largest {
    /// The weight.
    pub weight: f64,
    /// Name of the first column with the weight.
    pub column: String,
    /// Line of a table, or frame of an array.
    pub place: String,
}

/// Name of a column, and the shapes that it drives.
type Column<'a> = (&'a str, &'a [usize]);

/// Location of a row in the file, and its weight in each column.
type Row = (String, Vec<f64>);

/// Reads a take: a `.csv` with named columns; or a `.npz` with `weights` (N, C) and `names` (C). Without `names`, the
/// columns are the face's shapes in order.
///
/// # Errors
/// The file cannot be read, has another ending, or is damaged; a column is unknown, or none drives a shape; two columns
/// drive the same shape with different weights; the tracking is lost in every row; or a `.npz` has different numbers of
/// columns and names, no frame, or a weight that is not finite.
pub fn read(path: &Path, shapes: &[String]) -> Result<Take, Error> {
    match extension(path).as_str() {
        "csv" => of_table(&csv::read(path)?, shapes),
        "npz" => of_arrays(path, shapes),
        _ => Err(unknown_format(path, ".csv or .npz")),
    }
}

impl Take {
    /// Counts the rows of the file, including rows without tracking.
    pub fn file_len(&self) -> usize {
        self.frames.len() + self.lost.len()
    }

    /// Picks every n-th frame of a range of row numbers; skips `from` rows first, and rows without tracking.
    ///
    /// # Errors
    /// [`ErrorKind::Value`](crate::ErrorKind::Value) if the range is empty, out of bounds or without a frame.
    pub fn pick(
        &self,
        range: &Range<usize>,
        from: usize,
        every: usize,
    ) -> Result<Vec<&[f64]>, Error> {
        let len = self.file_len();
        if range.is_empty() || range.end > len {
            return Err(wrong_range(range, len));
        }
        let picked = self.every(range, from, every);
        if picked.is_empty() {
            return Err(wrong_range(&(range.start + from..range.end), len));
        }
        Ok(picked)
    }

    /// Picks frames like [`Take::pick`]; the result may be empty.
    pub fn every(&self, range: &Range<usize>, from: usize, every: usize) -> Vec<&[f64]> {
        let numbers = range.clone().skip(from).step_by(every.max(1));
        let places = numbers.filter_map(|number| self.numbers.binary_search(&number).ok());
        places.map(|place| self.frames[place].as_slice()).collect()
    }
}

/// Makes the error of a range of frames that is empty or out of bounds.
fn wrong_range(range: &Range<usize>, len: usize) -> Error {
    let Range { start, end } = range;
    Error::value(format!(
        "frames {start}..{end}: expected a range within 0..{len} that is not empty"
    ))
}

fn of_table(table: &csv::Table, shapes: &[String]) -> Result<Take, Error> {
    let columns = Columns::of(&table.names, shapes);
    check_names(table, &columns.unknown)?;
    columns.check(shapes)?;
    let Columns { driven, skipped, .. } = columns;
    let used: Vec<usize> = (0..driven.len()).filter(|&at| !driven[at].is_empty()).collect();
    let count = table.names.iter().position(|name| is_count(name));
    let mut take = Take { skipped, ..Take::default() };
    let mut rows: Vec<Row> = Vec::new();
    for (number, row) in table.rows().iter().enumerate() {
        if is_lost(table, row, count, &used) {
            take.lost.push(row.line);
            continue;
        }
        rows.push((format!("line {}", row.line), table.numbers_of(row, &used)?));
        take.numbers.push(number);
    }
    if rows.is_empty() {
        let len = take.lost.len();
        return Err(Error::missing(format!(
            "has no frame: the tracking is lost in all {len} rows"
        )));
    }
    let column = |&at: &usize| (table.names[at].as_str(), driven[at].as_slice());
    let columns: Vec<Column<'_>> = used.iter().map(column).collect();
    filled(take, shapes, &columns, &rows)
}

/// Checks that the line of names is not missing: most of the names are not unknown numbers.
fn check_names(table: &csv::Table, unknown: &[String]) -> Result<(), Error> {
    let mut numbers = unknown.iter().filter(|name| table.number(name).is_some());
    match numbers.next() {
        Some(found) if 2 * (1 + numbers.count()) > table.names.len() => {
            Err(csv::no_names(1, found))
        }
        _ => Ok(()),
    }
}

/// Returns whether a row has no tracking: its count of weights is 0 or absent, or a used cell is empty.
///
/// - `count`: column with the number of weights, if there is one.
fn is_lost(table: &csv::Table, row: &csv::Row, count: Option<usize>, used: &[usize]) -> bool {
    let has = |column: usize| table.cell(row, column).is_some();
    let is_counted =
        |column: usize| table.cell(row, column).is_some_and(|cell| cell.parse::<f64>() != Ok(0.0));
    // In a file without counts, a short row is an error, not a row without tracking.
    count.is_some_and(|column| !is_counted(column))
        || row.len() == table.names.len() && !used.iter().all(|&column| has(column))
}

fn of_arrays(path: &Path, shapes: &[String]) -> Result<Take, Error> {
    let mut archive = Archive::open(path)?;
    let rows = archive.required::<f64, 1>("weights", &[0])?;
    let (n, width) = (rows.lead[0], rows.lead[1]);
    if n == 0 {
        return Err(wrong_range(&(0..0), 0));
    }
    if !rows.data.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(not_finite("weights"));
    }
    let names = archive.texts("names")?;
    count("weights", "columns", names.as_ref().map_or(shapes.len(), Vec::len), width)?;
    let names = names.as_deref().unwrap_or(shapes);
    let columns = Columns::of(names, shapes);
    columns.check(shapes)?;
    let Columns { driven, skipped, .. } = columns;
    let columns: Vec<Column<'_>> =
        names.iter().map(String::as_str).zip(driven.iter().map(Vec::as_slice)).collect();
    let rows = rows.data.as_flattened().chunks(width.max(1)).map(<[f64]>::to_vec);
    let rows: Vec<Row> = (0..n).map(|row| format!("frame {row}")).zip(rows).collect();
    let take = Take { numbers: (0..n).collect(), skipped, ..Take::default() };
    filled(take, shapes, &columns, &rows)
}

/// Fills a take: each shape gets the weights of its first column.
///
/// # Errors
/// [`ErrorKind::Mismatch`](crate::ErrorKind::Mismatch): two columns of a shape differ.
fn filled(
    take: Take,
    shapes: &[String],
    columns: &[Column<'_>],
    rows: &[Row],
) -> Result<Take, Error> {
    let mut drivers = vec![Vec::new(); shapes.len()];
    for (column, (_, driven)) in columns.iter().enumerate() {
        driven.iter().for_each(|&shape| drivers[shape].push(column));
    }
    check(shapes, &drivers, columns, rows)?;
    let frame = |(_, row): &Row| {
        drivers.iter().map(|all| all.first().map_or(0.0, |&at: &usize| row[at])).collect()
    };
    let frames = rows.iter().map(frame).collect();
    let all = rows
        .iter()
        .flat_map(|(place, row)| drivers.iter().flatten().map(move |&at| (row[at], at, place)));
    // Keeps the first of equal weights.
    let largest = all.reduce(|most, next| if next.0.abs() > most.0.abs() { next } else { most });
    let largest = largest.filter(|(weight, ..)| *weight != 0.0).map(|(weight, at, place)| {
        Largest { weight, column: columns[at].0.to_owned(), place: place.clone() }
    });
    Ok(Take { frames, largest, ..take })
}

/// Checks that all columns of a shape agree.
///
/// - `drivers`: columns that drive each shape, S.
fn check(
    shapes: &[String],
    drivers: &[Vec<usize>],
    columns: &[Column<'_>],
    rows: &[Row],
) -> Result<(), Error> {
    let pairs = drivers.iter().zip(shapes).flat_map(|(drivers, shape)| {
        drivers.windows(2).map(move |pair| (shape, [pair[0], pair[1]]))
    });
    let mut differing = pairs.filter_map(|(shape, pair)| {
        // The runtime holds weights in f32, and programs write different numbers of digits.
        let differs = |(_, row): &&Row| row[pair[0]] as f32 != row[pair[1]] as f32;
        rows.iter().find(differs).map(|row| (shape, pair, row))
    });
    let Some((shape, pair, (place, row))) = differing.next() else { return Ok(()) };
    let [first, second] = pair.map(|at| columns[at].0);
    let [a, b] = pair.map(|at| row[at]);
    let remedy = match 1 + differing.count() {
        1 => "them".to_owned(),
        pairs => format!("each of {pairs} such pairs"),
    };
    Err(Error::mismatch(format!(
        "columns {first:?} and {second:?} both drive shape {shape:?}, and differ in {place}: {a} and {b}: \
         remove one of {remedy}"
    )))
}

/// Formats weights as CSV: a line of names, then a line per frame with its number first.
///
/// # Errors
/// The writer of the table fails.
pub fn to_csv(shapes: &[String], frames: &[(usize, Vec<f64>)]) -> Result<Vec<u8>, Error> {
    let wrong = |error: ::csv::Error| Error::write(error.into());
    let mut out = ::csv::Writer::from_writer(Vec::new());
    out.write_record(std::iter::once("frame").chain(shapes.iter().map(String::as_str)))
        .map_err(wrong)?;
    for (frame, weights) in frames {
        let numbers = weights.iter().map(|weight| (*weight as f32).to_string());
        out.write_record(std::iter::once(frame.to_string()).chain(numbers)).map_err(wrong)?;
    }
    out.into_inner().map_err(|error| Error::write(error.into_error()))
}
