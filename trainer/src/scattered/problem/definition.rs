//! Samples of a function, and what they are fitted with.

use super::error::ProblemError;
use super::options::ProblemOptions;
use crate::scattered::model::{Input, InputKind, Output};

/// Samples of a function from named inputs to named outputs.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The function's name.
    pub name: String,
    /// Its inputs.
    pub inputs: Vec<Input>,
    /// Its outputs.
    pub outputs: Vec<Output>,
    /// What is given of all inputs, a row a sample.
    pub sites: Vec<Vec<f64>>,
    /// Numbers of all outputs, likewise.
    pub values: Vec<Vec<f64>>,
    /// Lines of a CSV that the samples are in; none of other files.
    pub lines: Vec<u64>,
    /// What they are fitted with.
    pub options: ProblemOptions,
}

impl Problem {
    /// Checks that rows are there, as many of values as of sites, and each as long as inputs and outputs
    /// are.
    ///
    /// # Errors
    /// [`ProblemError::Empty`], [`ProblemError::Rows`], [`ProblemError::Row`] and [`ProblemError::Twice`], in this
    /// order.
    pub(super) fn check(self) -> Result<Self, ProblemError> {
        if self.sites.is_empty() {
            return Err(ProblemError::Empty);
        }
        let (sites, values) = (self.sites.len(), self.values.len());
        if sites != values {
            return Err(ProblemError::Rows { sites, values });
        }
        let given: usize = self.inputs.iter().map(|input| input.kind.given_len()).sum();
        let numbers: usize = self.outputs.iter().map(|output| output.kind.number_len()).sum();
        for (what, rows, expected) in
            [("sites", &self.sites, given), ("values", &self.values, numbers)]
        {
            if let Some(row) = rows.iter().position(|row| row.len() != expected) {
                let found = rows[row].len();
                return Err(ProblemError::Row { what, row, expected, found });
            }
        }
        let inputs: Vec<&str> = self.inputs.iter().map(|input| input.name.as_str()).collect();
        let outputs: Vec<&str> = self.outputs.iter().map(|output| output.name.as_str()).collect();
        for (what, names) in [("inputs", inputs), ("outputs", outputs)] {
            if let Some(at) = (0..names.len()).find(|&at| names[..at].contains(&names[at])) {
                return Err(ProblemError::Twice { what, name: names[at].to_owned() });
            }
        }
        Ok(self)
    }

    /// Names the row of a sample: a line of a CSV, else the row, from 0.
    pub fn row(&self, row: usize) -> String {
        self.lines.get(row).map_or_else(|| format!("row {row}"), |line| format!("line {line}"))
    }

    /// Names two of them.
    pub fn rows(&self, first: usize, second: usize) -> String {
        match (self.lines.get(first), self.lines.get(second)) {
            (Some(first), Some(second)) => format!("lines {first} and {second}"),
            _ => format!("rows {first} and {second}"),
        }
    }

    /// Names a row of sites or values.
    pub fn place(&self, row: usize, of: &str) -> String {
        let row = self.row(row);
        if self.lines.is_empty() { format!("{row} of {of}") } else { row }
    }

    /// Lists the inputs that are given as Euler angles.
    pub fn euler_inputs(&self) -> Vec<&str> {
        let is_euler =
            |input: &&Input| matches!(input.kind, InputKind::Rotation { order: Some(_), .. });
        self.inputs.iter().filter(is_euler).map(|input| input.name.as_str()).collect()
    }
}
