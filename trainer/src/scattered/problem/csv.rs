//! Problems as CSV: a line of names, then a line per sample.
//!
//! Columns `a.x, a.y, a.z` are one vector, and `a.x, a.y, a.z, a.w` one quaternion. Columns `a.rx, a.ry, a.rz` are one
//! rotation by angles in degrees about x, then y, then z.

use super::definition::{Problem, ProblemOptions};
use super::json::{WrittenInput, WrittenOutput, wrong_kind};
use crate::Error;
use crate::formats::csv;
use crate::scattered::model::{Input, InputKind, Output};

/// Table of numbers with named columns.
pub(super) struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// Line number of each row.
    lines: Vec<u64>,
}

/// Columns that form one input or output.
struct Group {
    name: String,
    /// Kind, as in a problem in JSON.
    kind: &'static str,
    columns: Vec<usize>,
}

/// Kind of the angles about x, then y, then z.
const ANGLES: &str = "euler XYZ";
/// Kinds of several columns, with the name endings of the columns, the longest list first.
const PARTS: [(&str, &[&str]); 3] = [
    ("quaternion", &[".x", ".y", ".z", ".w"]),
    ("vector3", &[".x", ".y", ".z"]),
    (ANGLES, &[".rx", ".ry", ".rz"]),
];

impl Table {
    /// Reads a table. Columns without a name and without cells are ignored.
    ///
    /// # Errors
    /// If the text is not a CSV of numbers, or a column has cells but no name.
    pub(super) fn parse(text: &[u8]) -> Result<Self, Error> {
        let table = csv::Table::parse(text)?;
        let name = |column: usize| table.names[column].as_str();
        let is_blank = |column| table.rows().iter().all(|row| table.cell(row, column).is_none());
        let all = 0..table.names.len();
        let columns: Vec<usize> =
            all.filter(|&column| !(name(column).is_empty() && is_blank(column))).collect();
        if let Some(column) = columns.iter().find(|column| name(**column).is_empty()) {
            let number = column + 1;
            return Err(Error::missing(format!(
                "line 1: column {number} has no name: give it one, or take the column away"
            )));
        }
        let rows = table.numbers(&columns).collect::<Result<Vec<_>, _>>()?;
        let (lines, rows) = rows.into_iter().unzip();
        Ok(Self {
            names: columns.iter().map(|&column| name(column).to_owned()).collect(),
            rows,
            lines,
        })
    }

    /// Returns the columns of inputs, in their order.
    ///
    /// # Errors
    /// If a column does not exist.
    pub(super) fn columns(&self, names: &[String]) -> Result<Vec<Vec<f64>>, Error> {
        let place = |name: &String| {
            let missing = || no_column(name, &self.names.join(", "));
            self.names.iter().position(|own| own == name).ok_or_else(missing)
        };
        let places = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        Ok(self.rows.iter().map(|row| places.iter().map(|&at| row[at]).collect()).collect())
    }

    /// Groups columns that belong together.
    fn groups(&self) -> Vec<Group> {
        let mut groups = Vec::new();
        let mut at = 0;
        while at < self.names.len() {
            let group = PARTS.into_iter().find_map(|(kind, parts)| {
                let stem = self.names[at].strip_suffix(parts[0])?;
                let own = self.names.get(at..at + parts.len())?;
                let fits =
                    own.iter().zip(parts).all(|(own, part)| own.strip_suffix(part) == Some(stem));
                fits.then(|| (stem.to_owned(), kind, parts))
            });
            let alone = || (self.names[at].clone(), "scalar", &[""] as &[&str]);
            let (name, kind, parts) = group.unwrap_or_else(alone);
            groups.push(Group { name, kind, columns: (at..at + parts.len()).collect() });
            at += parts.len();
        }
        groups
    }

    /// Makes a problem of the table.
    ///
    /// - `outputs`: names of the outputs; empty for the last column. All other columns are inputs.
    ///
    /// # Errors
    /// If an output is not a column, or is angles; errors of [`Problem::check`].
    pub(super) fn problem(&self, name: &str, outputs: &[String]) -> Result<Problem, Error> {
        let groups = self.groups();
        if let Some(name) = outputs.iter().find(|name| groups.iter().all(|g| g.name != **name)) {
            let found = groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(no_column(name, &found));
        }
        let last = groups.last().map(|group| group.name.clone());
        let is_output = |group: &&Group| match outputs {
            [] => Some(&group.name) == last.as_ref(),
            named => named.contains(&group.name),
        };
        let (own, rest): (Vec<&Group>, Vec<&Group>) = groups.iter().partition(is_output);
        let numbers = |groups: &[&Group]| -> Vec<Vec<f64>> {
            let columns: Vec<usize> = groups.iter().flat_map(|g| g.columns.clone()).collect();
            self.rows.iter().map(|row| columns.iter().map(|&at| row[at]).collect()).collect()
        };
        let input = |group: &&Group| WrittenInput::of(&group.name, group.kind).input();
        Problem {
            name: name.to_owned(),
            inputs: rest.iter().map(input).collect::<Result<_, _>>()?,
            outputs: own.iter().map(|group| group.output()).collect::<Result<_, _>>()?,
            sites: numbers(&rest),
            values: numbers(&own),
            lines: self.lines.clone(),
            options: ProblemOptions::default(),
        }
        .check()
    }
}

impl Group {
    fn output(&self) -> Result<Output, Error> {
        if self.kind == ANGLES {
            let expected = "a number, .x .y .z or .x .y .z .w";
            return Err(wrong_kind("output", &self.name, expected, "angles"));
        }
        WrittenOutput::of(&self.name, self.kind).output()
    }
}

/// Returns the error of a column that does not exist.
///
/// - `found`: names of the existing columns.
fn no_column(name: &str, found: &str) -> Error {
    Error::missing(format!("there is no column \"{name}\"; there are {found}"))
}

/// Lists the names of an input's columns.
pub(super) fn column_names(input: &Input) -> Vec<String> {
    let parts: &[&str] = match input.kind {
        InputKind::Scalar => &[""],
        InputKind::Vector3 => PARTS[1].1,
        InputKind::Rotation { order: None, .. } => PARTS[0].1,
        InputKind::Rotation { order: Some(_), .. } => PARTS[2].1,
    };
    parts.iter().map(|part| format!("{}{part}", input.name)).collect()
}
