//! Takes: weights of a face's shapes, frame by frame.

use super::basis::not_finite;
use super::names::{Columns, columns, is_count};
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

/// Columns that drive shapes, with their weights.
struct DrivingColumns<'a> {
    names: Vec<&'a str>,
    /// Columns that drive each shape, S.
    drivers: Vec<Vec<usize>>,
    /// Weights of the columns, row by row.
    rows: Vec<Vec<f64>>,
    /// Location of each row in the file.
    places: Vec<String>,
}

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
        check(range, len)?;
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

fn check(range: &Range<usize>, len: usize) -> Result<(), Error> {
    if range.start < range.end && range.end <= len {
        return Ok(());
    }
    Err(wrong_range(range, len))
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
    let (mut rows, mut places) = (Vec::new(), Vec::new());
    for (number, row) in table.rows().iter().enumerate() {
        if is_lost(table, row, count, &used) {
            take.lost.push(row.line);
            continue;
        }
        rows.push(table.numbers_of(row, &used)?);
        places.push(format!("line {}", row.line));
        take.numbers.push(number);
    }
    if rows.is_empty() {
        let len = take.lost.len();
        return Err(Error::missing(format!(
            "has no frame: the tracking is lost in all {len} rows"
        )));
    }
    let names = used.iter().map(|&at| table.names[at].as_str()).collect();
    let drivers = drivers(used.iter().map(|&at| driven[at].as_slice()), shapes.len());
    DrivingColumns { names, drivers, rows, places }.into_take(take, shapes)
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
    let Columns { driven, skipped, .. } = columns(names, shapes)?;
    let driving = DrivingColumns {
        names: names.iter().map(String::as_str).collect(),
        drivers: drivers(driven.iter().map(Vec::as_slice), shapes.len()),
        rows: rows.data.as_flattened().chunks(width.max(1)).map(<[f64]>::to_vec).collect(),
        places: (0..n).map(|row| format!("frame {row}")).collect(),
    };
    driving.into_take(Take { numbers: (0..n).collect(), skipped, ..Take::default() }, shapes)
}

/// Lists the columns that drive each shape, S.
///
/// - `driven`: shapes of each column.
fn drivers<'a>(driven: impl Iterator<Item = &'a [usize]>, shape_len: usize) -> Vec<Vec<usize>> {
    let mut drivers = vec![Vec::new(); shape_len];
    for (column, shapes) in driven.enumerate() {
        shapes.iter().for_each(|&shape| drivers[shape].push(column));
    }
    drivers
}

impl DrivingColumns<'_> {
    /// Gives each shape the weights of its first column.
    ///
    /// # Errors
    /// [`ErrorKind::Mismatch`](crate::ErrorKind::Mismatch): two columns of a shape differ.
    fn into_take(self, take: Take, shapes: &[String]) -> Result<Take, Error> {
        self.check(shapes)?;
        let weight = |row: &[f64], drivers: &[usize]| drivers.first().map_or(0.0, |&at| row[at]);
        let frame = |row: &Vec<f64>| self.drivers.iter().map(|all| weight(row, all)).collect();
        let frames = self.rows.iter().map(frame).collect();
        Ok(Take { frames, largest: self.largest(), ..take })
    }

    /// Checks that all columns of a shape agree.
    fn check(&self, shapes: &[String]) -> Result<(), Error> {
        let pairs = self.drivers.iter().zip(shapes).flat_map(|(drivers, shape)| {
            drivers.windows(2).map(move |pair| (shape, [pair[0], pair[1]]))
        });
        let mut differing = pairs.filter_map(|(shape, pair)| {
            // The runtime holds weights in f32, and programs write different numbers of digits.
            let differs = |row: &Vec<f64>| row[pair[0]] as f32 != row[pair[1]] as f32;
            self.rows.iter().position(differs).map(|row| (shape, pair, row))
        });
        let Some((shape, pair, row)) = differing.next() else { return Ok(()) };
        let [first, second] = pair.map(|at| self.names[at]);
        let [a, b] = pair.map(|at| self.rows[row][at]);
        let place = &self.places[row];
        let remedy = match 1 + differing.count() {
            1 => "them".to_owned(),
            pairs => format!("each of {pairs} such pairs"),
        };
        Err(Error::mismatch(format!(
            "columns {first:?} and {second:?} both drive shape {shape:?}, and differ in {place}: {a} and {b}: \
             remove one of {remedy}"
        )))
    }

    fn largest(&self) -> Option<Largest> {
        let columns = || self.drivers.iter().flatten();
        let all = self
            .rows
            .iter()
            .zip(&self.places)
            .flat_map(|(row, place)| columns().map(move |&at| (row[at], at, place)));
        // Keeps the first of equal weights.
        let largest =
            all.reduce(|most, next| if next.0.abs() > most.0.abs() { next } else { most });
        largest.filter(|(weight, ..)| *weight != 0.0).map(|(weight, at, place)| Largest {
            weight,
            column: self.names[at].to_owned(),
            place: place.clone(),
        })
    }
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
