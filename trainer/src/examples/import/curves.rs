//! Curves of a scene: weights of its shapes, or a table beside the scene.

use super::clips::frame_len;
use crate::Error;
use crate::examples::curves::places;
use crate::examples::{Clip, Curves, Examples};
use crate::formats::csv::{self, NO_VALUES, TIME, Table};
use crate::formats::scene::CurveTrack;
use std::path::Path;

/// Largest difference of the weights of two meshes that count as one curve: covers rounding to f32.
const SAME: f64 = 1e-6;

/// Curves of all frames.
#[derive(Debug, Default, PartialEq)]
pub(super) struct SampledCurves {
    /// Names, C.
    pub(super) names: Vec<String>,
    /// Values, N x C, frame-major.
    pub(super) values: Vec<f64>,
}

impl SampledCurves {
    /// Moves the curves to examples of the same frames.
    pub(super) fn put(self, examples: &mut Examples) {
        examples.curve_names = self.names;
        examples.curves = self.values;
    }

    /// Joins columns of N values.
    fn of_columns(names: Vec<String>, columns: &[Vec<f64>]) -> Self {
        let frames = 0..columns.first().map_or(0, Vec::len);
        let values = frames.flat_map(|frame| columns.iter().map(move |column| column[frame]));
        let values = values.collect();
        Self { names, values }
    }
}

/// Returns the chosen curves among the weights of a scene's shapes. Shapes with one name on several meshes are one
/// curve.
///
/// # Errors
/// - A chosen curve is missing, or all curves are chosen and there is none.
/// - Two meshes have a chosen curve with different weights.
pub(super) fn of_shapes(tracks: &[CurveTrack], choice: Curves<'_>) -> Result<SampledCurves, Error> {
    let mut known: Vec<String> = Vec::new();
    for track in tracks.iter().filter(|track| !track.name.is_empty()) {
        if !known.contains(&track.name) {
            known.push(track.name.clone());
        }
    }
    let chosen = match choice {
        Curves::Usual | Curves::None => return Ok(SampledCurves::default()),
        Curves::All if known.is_empty() => {
            return Err(Error::missing(
                "has no curve: no mesh has a shape with a name; export the shape keys (morph targets, blendshapes), or \
                 give the curves as a table with --curves-from",
            ));
        }
        Curves::All => &known,
        Curves::Named(names) => names,
    };
    let own = |place: usize| one(tracks, &known[place]);
    let columns = places(&known, chosen)?.into_iter().map(own).collect::<Result<Vec<_>, _>>()?;
    Ok(SampledCurves::of_columns(chosen.to_vec(), &columns))
}

/// Returns the weights that all meshes give to a curve.
fn one(tracks: &[CurveTrack], name: &str) -> Result<Vec<f64>, Error> {
    let mut own = tracks.iter().filter(|track| track.name == name);
    let Some(first) = own.next() else { return Ok(Vec::new()) };
    for other in own {
        let pairs = first.weights.iter().zip(&other.weights).enumerate();
        let differs = |(_, (a, b)): &(usize, (&f64, &f64))| (*a - *b).abs() > SAME;
        if let Some((frame, (a, b))) = pairs.into_iter().find(differs) {
            let error = Error::mismatch(format!(
                "curve {name} is {a} on mesh {} and {b} on mesh {}: give the two shapes one motion, rename one of \
                 them, or choose other curves with --curve",
                first.mesh, other.mesh
            ));
            return Err(error.in_frame(frame));
        }
    }
    Ok(first.weights.clone())
}

/// Reads the chosen curves of a table (`.csv`) for the frames of a scene's clips.
///
/// A table with a column `time`, in seconds, is interpolated at the times of the frames. Otherwise row i belongs to
/// frame i.
///
/// # Errors
/// The error names the file: the file cannot be read, a chosen column is missing, a cell is not a number, times do not
/// ascend or do not cover a frame, or there are several clips and a column `time`; or rows and frames differ in number.
pub(super) fn of_table(
    path: &Path,
    clips: &[Clip],
    choice: Curves<'_>,
) -> Result<SampledCurves, Error> {
    let read = || parsed(&csv::read(path)?, clips, choice);
    read().map_err(|error: Error| error.in_file(path))
}

fn parsed(table: &Table, clips: &[Clip], choice: Curves<'_>) -> Result<SampledCurves, Error> {
    let stem = |name: &str| -> String {
        name.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect()
    };
    let holds_values = |name: &&String| !NO_VALUES.contains(&stem(name).as_str());
    let known: Vec<String> = table.names.iter().filter(holds_values).cloned().collect();
    let names = match choice {
        Curves::None => return Ok(SampledCurves::default()),
        _ if known.is_empty() => {
            let found = table.names.join(", ");
            return Err(Error::missing(format!("line 1: no column is a curve; there are {found}")));
        }
        Curves::Usual | Curves::All => known,
        Curves::Named(names) => {
            places(&known, names)?;
            names.to_vec()
        }
    };
    let time = table.names.iter().position(|name| stem(name) == TIME);
    let mut columns = places(&table.names, &names)?;
    columns.extend(time);
    let (mut lines, mut rows) = (Vec::new(), Vec::new());
    for row in table.numbers(&columns) {
        let (line, numbers) = row?;
        lines.push(line);
        rows.push(numbers);
    }
    let Some(time) = time else {
        check_len(rows.len(), clips)?;
        return Ok(SampledCurves { names, values: rows.concat() });
    };
    let times: Vec<f64> = rows.iter_mut().filter_map(Vec::pop).collect();
    if let Some(place) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        let (line, column, [a, b]) =
            (lines[place + 1], &table.names[time], [0, 1].map(|next| times[place + next]));
        return Err(Error::value(format!(
            "line {line}, column {column:?}: expected a time above {a}, found {b}"
        )));
    }
    let [clip] = clips else {
        return Err(Error::mismatch(format!(
            "has a column {:?}, and the scene has {} clips: choose one with --clip, or remove the column and give a row \
             for each frame",
            table.names[time],
            clips.len()
        )));
    };
    let values = clip.times.iter().enumerate().map(|(frame, at)| {
        between(&times, &rows, *at).ok_or_else(|| {
            let [first, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or_default());
            let error = Error::missing(format!(
                "clip {} plays it at {at:.4} s, and the rows are from {first:.4} to {last:.4} s: give rows for the whole \
                 clip, in seconds of the scene",
                clip.name
            ));
            error.in_frame(frame)
        })
    });
    Ok(SampledCurves { names, values: values.collect::<Result<Vec<_>, _>>()?.concat() })
}

/// Checks that there is a row for each frame.
fn check_len(rows: usize, clips: &[Clip]) -> Result<(), Error> {
    let frames = frame_len(clips);
    if rows == frames {
        return Ok(());
    }
    let clips: Vec<_> = clips.iter().map(Clip::describe).collect();
    Err(Error::mismatch(format!(
        "has {rows} rows, the scene's clips have {frames} frames ({}): give a row for each frame, sample the scene at the \
         rate of the rows with --fps, or add a column time, in seconds",
        clips.join(", ")
    )))
}

/// Interpolates rows at a time; `None` outside the rows by more than half a step.
fn between(times: &[f64], rows: &[Vec<f64>], at: f64) -> Option<Vec<f64>> {
    let (first, last) = (times.first()?, times.last()?);
    let slack = 0.5 * (last - first) / (times.len().max(2) - 1) as f64;
    if at < first - slack || at > last + slack {
        return None;
    }
    let after = times.partition_point(|time| *time <= at);
    let Some(before) = after.checked_sub(1) else { return rows.first().cloned() };
    let Some(next) = rows.get(after) else { return rows.last().cloned() };
    let part = (at - times[before]) / (times[after] - times[before]);
    Some(rows[before].iter().zip(next).map(|(a, b)| a + part * (b - a)).collect())
}
