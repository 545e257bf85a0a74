//! Samples of a function, and the options of their fit as a person writes them.

use crate::Error;
use crate::scattered::hyper;
use crate::scattered::model::{Input, InputKind, Output};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use serde_json::Value;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// Samples of a function from named inputs to named outputs.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Name of the function.
    pub name: String,
    /// Inputs of the function.
    pub inputs: Vec<Input>,
    /// Outputs of the function.
    pub outputs: Vec<Output>,
    /// Given numbers of all inputs, a row a sample.
    pub sites: Vec<Vec<f64>>,
    /// Numbers of all outputs, a row a sample.
    pub values: Vec<Vec<f64>>,
    /// CSV lines of the samples; empty for other files.
    pub lines: Vec<u64>,
    /// Options of the fit.
    pub options: ProblemOptions,
}

impl Problem {
    /// Checks the rows: there are as many values as sites, and each row has as many numbers as its inputs or outputs.
    ///
    /// # Errors
    /// In this order:
    /// - if there are no samples;
    /// - if the numbers of sites and values differ;
    /// - if a row has too few or too many numbers;
    /// - if two inputs, or two outputs, have the same name.
    pub(super) fn check(self) -> Result<Self, Error> {
        if self.sites.is_empty() {
            return Err(Error::missing("there are no samples"));
        }
        let (sites, values) = (self.sites.len(), self.values.len());
        if sites != values {
            return Err(wrong_rows(sites, values));
        }
        let given: usize = self.inputs.iter().map(|input| input.kind.given_len()).sum();
        let numbers: usize = self.outputs.iter().map(|output| output.kind.number_len()).sum();
        for (what, rows, expected) in
            [("sites", &self.sites, given), ("values", &self.values, numbers)]
        {
            if let Some(row) = rows.iter().position(|row| row.len() != expected) {
                let found = rows[row].len();
                return Err(Error::mismatch(format!(
                    "row {row} of {what}: expected {expected} numbers, found {found}"
                )));
            }
        }
        let inputs: Vec<&str> = self.inputs.iter().map(|input| input.name.as_str()).collect();
        let outputs: Vec<&str> = self.outputs.iter().map(|output| output.name.as_str()).collect();
        for (what, names) in [("inputs", inputs), ("outputs", outputs)] {
            if let Some(at) = (0..names.len()).find(|&at| names[..at].contains(&names[at])) {
                return Err(Error::value(format!("two {what} are named \"{}\"", names[at])));
            }
        }
        Ok(self)
    }

    /// Names the row of a sample: a line of a CSV, otherwise the row, from 0.
    pub fn row(&self, row: usize) -> String {
        self.lines.get(row).map_or_else(|| format!("row {row}"), |line| format!("line {line}"))
    }

    /// Names the rows of two samples.
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

    /// Lists the inputs that are Euler angles.
    pub fn euler_inputs(&self) -> Vec<&str> {
        let is_euler =
            |input: &&Input| matches!(input.kind, InputKind::Rotation { order: Some(_), .. });
        self.inputs.iter().filter(is_euler).map(|input| input.name.as_str()).collect()
    }
}

/// Returns the error of sites and values of different numbers.
pub(super) fn wrong_rows(sites: usize, values: usize) -> Error {
    Error::mismatch(format!("expected a row of values for each of {sites} sites, found {values}"))
}

/// Options of a fit. Omitted options are chosen by leaving samples out, or have the default named here.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "options by name")]
pub struct ProblemOptions {
    /// Rules of the fit.
    pub mode: Mode,
    /// Name of the kernel; default: gaussian.
    pub kernel: Option<String>,
    /// Reciprocal of the width, in mean distances of the samples; unscaled in the other modes. A learned metric starts
    /// from it.
    pub epsilon: Option<f64>,
    /// Smoothing λ; default: 0, which interpolates.
    pub smoothing: Option<Smoothing>,
    /// Largest deviation of the file, over a value's range; default:
    /// [`F32_ERROR`](crate::scattered::deviation::F32_ERROR).
    pub f32_error: Option<f64>,
    /// Degree of the polynomial, -1 for none; default: the least degree that the kernel allows.
    pub degree: Option<i32>,
    /// For SciPy's mode: number of nearest samples that determine the function at a query.
    pub neighbors: Option<usize>,
    /// Number of centres; default: every sample is a centre.
    pub centres: Option<usize>,
    /// Options for learning centres and metric.
    pub learn: Option<Learn>,
    /// Replaces the values by weights of the samples: an output per sample, 1 at the sample and 0 at the others.
    pub weights: bool,
    /// Averages samples of one site with different values.
    pub average: bool,
    /// Group number of each sample. Samples of a group are left out together.
    pub groups: Option<Vec<usize>>,
    /// Row of the neutral sample; default: the first.
    pub neutral: usize,
    /// Rule for queries far from the samples; default: free.
    #[serde(deserialize_with = "query_rule")]
    pub outside: Option<QueryRule>,
    /// Rule by which marked outputs are divided by their sum.
    #[serde(deserialize_with = "normalise")]
    pub normalise: Option<Normalise>,
    /// For S2's mode: radius; default: 1.
    pub radius: Option<f64>,
    /// For S2's mode: divides columns of sites by their lengths.
    pub normalise_features: bool,
}

/// Smoothing λ, as a person writes it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub enum Smoothing {
    /// One λ for all samples.
    Given(f64),
    /// λ of each row.
    Each(Vec<f64>),
    /// The λ that predicts left-out samples best.
    Chosen,
}

impl TryFrom<Value> for Smoothing {
    type Error = String;

    /// Reads a number, numbers or `auto`.
    fn try_from(value: Value) -> Result<Self, String> {
        let numbers = |all: &[Value]| all.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
        let read = match &value {
            Value::Number(number) => number.as_f64().map(Self::Given),
            Value::Array(all) => numbers(all).map(Self::Each),
            Value::String(word) if word == "auto" => Some(Self::Chosen),
            _ => None,
        };
        read.ok_or_else(|| {
            format!("expected a number, a list of numbers (one a sample) or auto, found {value}")
        })
    }
}

/// Rules of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Rules of METHOD §2.
    #[default]
    Sinew,
    /// Rules of SciPy's `RBFInterpolator`.
    Scipy,
    /// Rules of S2, as its post publishes them.
    Published,
}

/// Options for learning centres and metric.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "options of `learn` by name")]
pub struct Learn {
    /// Method of learning.
    pub method: LearnMethod,
    /// Number of centres; default: 12, or fewer if there are fewer samples.
    pub centres: Option<usize>,
    /// Learned part of the metric.
    pub metric: hyper::Entries,
    /// Number of rows of a low-rank metric.
    pub rank: Option<usize>,
    /// Number of starts.
    pub seeds: u64,
    /// Largest number of energy evaluations per start.
    pub evaluations: usize,
    /// Ridge λ of the coefficients.
    pub ridge: f64,
}

/// Method of learning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LearnMethod {
    /// Solves for the coefficients exactly, and for the rest by L-BFGS.
    #[default]
    Projection,
    /// Follows S1's dynamical system.
    Flow,
    /// Makes S1's random changes, with a falling temperature.
    Metropolis,
}

impl Default for Learn {
    fn default() -> Self {
        Self {
            method: LearnMethod::default(),
            centres: None,
            metric: hyper::Entries::default(),
            rank: None,
            seeds: 4,
            evaluations: 1000,
            ridge: 1e-9,
        }
    }
}

impl LearnMethod {
    /// Returns the method with its parameters.
    pub fn method(self) -> hyper::Method {
        match self {
            Self::Projection => hyper::Method::VariableProjection,
            Self::Flow => hyper::Method::GradientFlow { step: 1e-2 },
            Self::Metropolis => hyper::Method::Metropolis { reach: 0.1, temperatures: [1e-3, 0.0] },
        }
    }
}

fn query_rule<'de, D: Deserializer<'de>>(from: D) -> Result<Option<QueryRule>, D::Error> {
    named(from, QueryRule::ALL, QueryRule::name)
}

fn normalise<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Normalise>, D::Error> {
    named(from, Normalise::ALL, Normalise::name)
}

/// Reads a rule by its name.
fn named<'de, D: Deserializer<'de>, T: Copy, const N: usize>(
    from: D,
    rules: [T; N],
    name: fn(T) -> &'static str,
) -> Result<Option<T>, D::Error> {
    let written = String::deserialize(from)?;
    let found = rules.into_iter().find(|rule| name(*rule) == written);
    let expected = rules.map(name).join(", ");
    let unknown = || D::Error::custom(format!("expected one of {expected}, found \"{written}\""));
    found.map(Some).ok_or_else(unknown)
}
