//! Tracks: observed positions of vertices, frame by frame.

use crate::Error;
use crate::formats::csv;
use sinew_runtime::prior::Pin;
use std::collections::BTreeMap;
use std::path::Path;

/// Observed positions of vertices, as pins, by frame number, ascending.
pub type Track = BTreeMap<usize, Vec<Pin>>;

const COLUMNS: [&str; 5] = ["frame", "vertex", "x", "y", "z"];
const STIFFNESS: &str = "stiffness";

/// Reads a `.csv` with the columns frame, vertex, x, y, z and, optionally, stiffness.
///
/// - `vertex_len`: number of the face's vertices, V.
///
/// # Errors
/// The file cannot be read or is no table of numbers; a column is missing; or a frame is not a whole number, a vertex
/// outside 0..V, or a stiffness not positive.
pub fn read(path: &Path, vertex_len: usize) -> Result<Track, Error> {
    of_table(&csv::read(path)?, vertex_len)
}

fn of_table(table: &csv::Table, vertex_len: usize) -> Result<Track, Error> {
    let mut columns: Vec<usize> =
        COLUMNS.iter().map(|name| table.column(name)).collect::<Result<_, _>>()?;
    columns.extend(table.column(STIFFNESS).ok());
    let mut track = Track::new();
    for row in table.numbers(&columns) {
        let (line, numbers) = row?;
        let whole = |place: usize, most: f64, expected: String| {
            let found = numbers[place];
            match found >= 0.0 && found <= most && found.fract() == 0.0 {
                true => Ok(found as usize),
                false => Err(wrong_cell(line, COLUMNS[place], &expected, found)),
            }
        };
        let frame = whole(0, f64::from(u32::MAX), "a whole number from 0 on".to_owned())?;
        let last = vertex_len as f64 - 1.0;
        let vertex = whole(1, last, format!("a vertex from 0 to {last}"))?;
        let stiffness = numbers.get(5).copied().unwrap_or(1.0);
        if stiffness <= 0.0 {
            return Err(wrong_cell(line, STIFFNESS, "a number above 0", stiffness));
        }
        let at = [numbers[2], numbers[3], numbers[4]].map(|x| x as f32);
        let pin = Pin::new(vertex as u32, at).with_stiffness(stiffness as f32);
        track.entry(frame).or_default().push(pin);
    }
    Ok(track)
}

/// Makes the error of a cell whose number is not allowed.
fn wrong_cell(line: u64, column: &str, expected: &str, found: f64) -> Error {
    Error::value(format!("line {line}, column {column:?}: expected {expected}, found {found}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::csv::Table;

    fn said(text: &str) -> String {
        let table = Table::parse(text.as_bytes()).unwrap();
        of_table(&table, 10).map_or_else(|error| error.to_string(), |track| format!("{track:?}"))
    }

    #[test]
    fn points_are_grouped_by_frame_in_file_order() {
        let text = "vertex,frame,x,y,z,stiffness\n3,7,1,2,3,2\n1,2,0,0,0,1\n9,7,4,5,6,0.5\n";
        let track = of_table(&Table::parse(text.as_bytes()).unwrap(), 10).unwrap();
        let point = |vertex, at, stiffness| Pin::new(vertex, at).with_stiffness(stiffness);
        let expected = [
            (2, vec![point(1, [0.0; 3], 1.0)]),
            (7, vec![point(3, [1.0, 2.0, 3.0], 2.0), point(9, [4.0, 5.0, 6.0], 0.5)]),
        ];
        assert_eq!(track, BTreeMap::from(expected));
    }

    #[test]
    fn bad_cells_are_named() {
        let head = "frame,vertex,x,y,z,stiffness\n0,1,0,0,0,1\n";
        for (line, expected) in [
            (
                "0.5,1,0,0,0,1",
                "line 3, column \"frame\": expected a whole number from 0 on, found 0.5",
            ),
            (
                "-1,1,0,0,0,1",
                "line 3, column \"frame\": expected a whole number from 0 on, found -1",
            ),
            ("0,10,0,0,0,1", "line 3, column \"vertex\": expected a vertex from 0 to 9, found 10"),
            ("0,1,0,0,0,0", "line 3, column \"stiffness\": expected a number above 0, found 0"),
            ("0,1,0,inf,0,1", "line 3, column \"y\": expected a number, found \"inf\""),
        ] {
            assert_eq!(said(&format!("{head}{line}\n")), expected);
        }
        assert_eq!(
            said("frame,x,y,z\n0,1,2,3\n"),
            "line 1: there is no column \"vertex\"; there are frame, x, y, z"
        );
    }
}
