//! A take: the weights of a face's shapes, frame by frame.

use super::error::FaceError;
use super::names::{Columns, columns, is_count};
use super::npz::count;
use crate::formats::extension::{extension, unknown_format};
use crate::formats::npz::Archive;
use crate::formats::{CsvError, FormatError, csv};
use std::ops::Range;
use std::path::Path;

/// Weights of S shapes over N frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Take {
    /// Weights, N x S; 0 of what no column drives.
    pub frames: Vec<Vec<f64>>,
    /// Number of each frame in the file, ascending, N; the first row has 0.
    pub numbers: Vec<usize>,
    /// Lines in which the tracking is lost, which give no frame.
    pub lost: Vec<u64>,
    /// Expressions and angles of the file that the face has no shape for.
    pub skipped: Vec<String>,
    /// The weight of the largest magnitude; `None` if all are 0.
    pub largest: Option<Largest>,
}

/// The largest weight of a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Largest {
    /// The weight.
    pub weight: f64,
    /// The column that has it first.
    pub column: String,
    /// The line of a table, or the frame of an array.
    pub place: String,
}

/// Columns of a take that drive shapes.
struct Driving<'a> {
    names: Vec<&'a str>,
    /// The columns that drive each shape, S.
    drivers: Vec<Vec<usize>>,
    /// Numbers of the columns, row by row.
    rows: Vec<Vec<f64>>,
    /// Where each row is in the file.
    places: Vec<String>,
}

/// Reads a take of a face: a `.csv` of named columns, or a `.npz` with `weights` (N, C) and, where they are not the
/// face's shapes in order, `names` (C).
///
/// # Errors
/// Those of the formats; [`FaceError::Names`] and [`FaceError::NoColumns`]; [`FaceError::Contradiction`];
/// [`FaceError::Lost`]; [`FaceError::Count`] where a `.npz` has not as many columns as names.
pub fn read(path: &Path, shapes: &[String]) -> Result<Take, FaceError> {
    match extension(path).as_str() {
        "csv" => of_table(&csv::read(path)?, shapes),
        "npz" => of_arrays(path, shapes),
        _ => Err(unknown_format(path, ".csv or .npz").into()),
    }
}

impl Take {
    /// Counts the frames of the file, those in which the tracking is lost included.
    pub fn file_len(&self) -> usize {
        self.frames.len() + self.lost.len()
    }

    /// Picks every n-th frame of a range of numbers in the file, from one on, without the lost ones.
    ///
    /// # Errors
    /// [`FaceError::Range`]: the range is empty or reaches beyond the take, or has no frame.
    pub fn pick(
        &self,
        range: &Range<usize>,
        from: usize,
        every: usize,
    ) -> Result<Vec<&[f64]>, FaceError> {
        let len = self.file_len();
        check(range, len)?;
        let picked = self.every(range, from, every);
        if picked.is_empty() {
            let first = range.start + from;
            return Err(FaceError::Range { what: "frames", first, end: range.end, len });
        }
        Ok(picked)
    }

    /// Picks frames as [`Take::pick`] does, perhaps none.
    pub fn every(&self, range: &Range<usize>, from: usize, every: usize) -> Vec<&[f64]> {
        let numbers = range.clone().skip(from).step_by(every.max(1));
        let places = numbers.filter_map(|number| self.numbers.binary_search(&number).ok());
        places.map(|place| self.frames[place].as_slice()).collect()
    }
}

fn check(range: &Range<usize>, len: usize) -> Result<(), FaceError> {
    if range.start < range.end && range.end <= len {
        return Ok(());
    }
    Err(FaceError::Range { what: "frames", first: range.start, end: range.end, len })
}

fn of_table(table: &csv::Table, shapes: &[String]) -> Result<Take, FaceError> {
    let Columns { driven, skipped } =
        columns(&table.names, shapes).map_err(|e| unnamed(e, table))?;
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
        return Err(FaceError::Lost { len: take.lost.len() });
    }
    let names = used.iter().map(|&at| table.names[at].as_str()).collect();
    let drivers = drivers(used.iter().map(|&at| driven[at].as_slice()), shapes.len());
    Driving { names, drivers, rows, places }.weigh(take, shapes)
}

/// Says that the line of names is missing where most names are numbers.
fn unnamed(error: FaceError, table: &csv::Table) -> FaceError {
    let FaceError::Names { unknown } = &error else { return error };
    let mut numbers =
        unknown.iter().map(|unknown| &unknown.name).filter(|name| table.number(name).is_some());
    match numbers.next() {
        Some(found) if 2 * (1 + numbers.count()) > table.names.len() => {
            CsvError::NoNames { line: 1, found: found.clone() }.into()
        }
        _ => error,
    }
}

/// Whether the tracking is lost in a row: its count of weights is 0 or absent, or a used cell is empty.
///
/// - `count`: the column of the count, where there is one.
fn is_lost(table: &csv::Table, row: &csv::Row, count: Option<usize>, used: &[usize]) -> bool {
    let has = |column: usize| table.cell(row, column).is_some();
    let is_counted =
        |column: usize| table.cell(row, column).is_some_and(|cell| cell.parse::<f64>() != Ok(0.0));
    // Without a count a short row is not lost but wrong.
    count.is_some_and(|column| !is_counted(column))
        || row.len() == table.names.len() && !used.iter().all(|&column| has(column))
}

fn of_arrays(path: &Path, shapes: &[String]) -> Result<Take, FaceError> {
    let mut archive = Archive::open(path)?;
    let rows = archive.required::<f64, 1>("weights", &[0])?;
    let (n, width) = (rows.lead[0], rows.lead[1]);
    if n == 0 {
        return Err(FaceError::Range { what: "frames", first: 0, end: 0, len: 0 });
    }
    if !rows.data.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(FaceError::NotFinite { array: "weights" });
    }
    let names = archive.texts("names")?;
    count("weights", "columns", names.as_ref().map_or(shapes.len(), Vec::len), width)?;
    let names = names.as_deref().unwrap_or(shapes);
    let Columns { driven, skipped } = columns(names, shapes)?;
    let driving = Driving {
        names: names.iter().map(String::as_str).collect(),
        drivers: drivers(driven.iter().map(Vec::as_slice), shapes.len()),
        rows: rows.data.as_flattened().chunks(width.max(1)).map(<[f64]>::to_vec).collect(),
        places: (0..n).map(|row| format!("frame {row}")).collect(),
    };
    driving.weigh(Take { numbers: (0..n).collect(), skipped, ..Take::default() }, shapes)
}

/// Lists the columns that drive each shape, S.
///
/// - `driven`: the shapes of each column.
fn drivers<'a>(driven: impl Iterator<Item = &'a [usize]>, shape_len: usize) -> Vec<Vec<usize>> {
    let mut drivers = vec![Vec::new(); shape_len];
    for (column, shapes) in driven.enumerate() {
        shapes.iter().for_each(|&shape| drivers[shape].push(column));
    }
    drivers
}

impl Driving<'_> {
    /// Gives each shape the numbers of the column that drives it.
    ///
    /// # Errors
    /// [`FaceError::Contradiction`]
    fn weigh(self, take: Take, shapes: &[String]) -> Result<Take, FaceError> {
        self.check(shapes)?;
        let weight = |row: &[f64], drivers: &[usize]| drivers.first().map_or(0.0, |&at| row[at]);
        let frame = |row: &Vec<f64>| self.drivers.iter().map(|all| weight(row, all)).collect();
        let frames = self.rows.iter().map(frame).collect();
        Ok(Take { frames, largest: self.largest(), ..take })
    }

    /// Checks that columns which drive one shape agree.
    fn check(&self, shapes: &[String]) -> Result<(), FaceError> {
        let pairs = self.drivers.iter().zip(shapes).flat_map(|(drivers, shape)| {
            drivers.windows(2).map(move |pair| (shape, [pair[0], pair[1]]))
        });
        let mut apart = pairs.filter_map(|(shape, pair)| {
            // The runtime has weights in f32; programs may write those with fewer or with more digits.
            let differs = |row: &Vec<f64>| row[pair[0]] as f32 != row[pair[1]] as f32;
            self.rows.iter().position(differs).map(|row| (shape, pair, row))
        });
        let Some((shape, pair, row)) = apart.next() else { return Ok(()) };
        Err(FaceError::Contradiction {
            shape: shape.clone(),
            columns: pair.map(|at| self.names[at].to_owned()),
            place: self.places[row].clone(),
            found: pair.map(|at| self.rows[row][at]),
            pairs: 1 + apart.count(),
        })
    }

    fn largest(&self) -> Option<Largest> {
        let columns = || self.drivers.iter().flatten();
        let all = self
            .rows
            .iter()
            .zip(&self.places)
            .flat_map(|(row, place)| columns().map(move |&at| (row[at], at, place)));
        // The first of equal ones.
        let largest =
            all.reduce(|most, next| if next.0.abs() > most.0.abs() { next } else { most });
        largest.filter(|(weight, ..)| *weight != 0.0).map(|(weight, at, place)| Largest {
            weight,
            column: self.names[at].to_owned(),
            place: place.clone(),
        })
    }
}

/// Writes weights as a table: a line of names, then a frame a line, its number first.
pub fn to_csv(shapes: &[String], frames: &[(usize, Vec<f64>)]) -> Result<Vec<u8>, FormatError> {
    let wrong = |error: ::csv::Error| FormatError::Write(error.into());
    let mut out = ::csv::Writer::from_writer(Vec::new());
    out.write_record(std::iter::once("frame").chain(shapes.iter().map(String::as_str)))
        .map_err(wrong)?;
    for (frame, weights) in frames {
        let numbers = weights.iter().map(|weight| (*weight as f32).to_string());
        out.write_record(std::iter::once(frame.to_string()).chain(numbers)).map_err(wrong)?;
    }
    out.into_inner().map_err(|error| FormatError::Write(error.into_error()))
}
