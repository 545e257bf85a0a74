//! Samples of a function, and what they are fitted with.
//! What a problem is fitted with, as a person writes it.

use super::error::ProblemError;
use crate::scattered::deviation::F32_ERROR;
use crate::scattered::hyper;
use crate::scattered::model::{Input, InputKind, Output};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use serde_json::Value;
use sinew_runtime::kernel::{Normalise, QueryRule};

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

/// What a problem is fitted with; what is left out is chosen by leaving samples out, or has the default
/// named here.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "options by name")]
pub struct ProblemOptions {
    /// Whose rules hold.
    pub mode: Mode,
    /// The kernel's name; gaussian.
    pub kernel: Option<String>,
    /// One over the width, in mean distances of the samples (those of the other modes as they are);
    /// that which a learned metric starts from.
    pub epsilon: Option<f64>,
    /// λ; 0, which interpolates, unless it is to be chosen.
    pub smoothing: Option<Smoothing>,
    /// Largest deviation of the file, over a value's range; [`F32_ERROR`].
    pub f32_error: f64,
    /// Degree of the polynomial; -1 without one, by default the least that the kernel allows.
    pub degree: Option<i32>,
    /// SciPy's mode: how many samples make the function at a query.
    pub neighbors: Option<usize>,
    /// Centres, where they are to be fewer than samples.
    pub centres: Option<usize>,
    /// Learns centres and metric.
    pub learn: Option<Learn>,
    /// Makes weights of the samples: an output each, 1 at its own sample and 0 at the others.
    pub weights: bool,
    /// Takes the mean of samples of one site that disagree.
    pub average: bool,
    /// Samples by groups that are left out together, a number each.
    pub groups: Option<Vec<usize>>,
    /// The sample that is neutral; the first.
    pub neutral: usize,
    /// What becomes of a query far from the samples.
    #[serde(deserialize_with = "query_rule")]
    pub outside: QueryRule,
    /// Whether marked outputs are divided by their sum.
    #[serde(deserialize_with = "normalise")]
    pub normalise: Option<Normalise>,
    /// S2's mode: the radius; 1.
    pub radius: Option<f64>,
    /// S2's mode: whether columns of sites are divided by their lengths.
    pub normalise_features: bool,
}

/// λ as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub enum Smoothing {
    /// This, of all samples.
    Given(f64),
    /// One of each row.
    Each(Vec<f64>),
    /// One that predicts left-out samples best.
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

/// Whose rules a fit follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// METHOD §2's.
    #[default]
    Sinew,
    /// Those of SciPy's `RBFInterpolator`.
    Scipy,
    /// S2's, as its post publishes them.
    Published,
}

/// What is learned.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "options of `learn` by name")]
pub struct Learn {
    /// How.
    pub method: LearnMethod,
    /// Centres; 12, or fewer where samples are fewer.
    pub centres: Option<usize>,
    /// The metric.
    pub metric: LearnMetric,
    /// Rows of a metric of low rank.
    pub rank: Option<usize>,
    /// Starts.
    pub seeds: u64,
    /// How often the energy may be evaluated from each.
    pub evaluations: usize,
    /// λ of the coefficients.
    pub ridge: f64,
}

/// A method of learning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LearnMethod {
    /// Coefficients solved exactly, the rest by L-BFGS.
    #[default]
    Projection,
    /// S1's dynamical system.
    Flow,
    /// S1's random changes, cooled.
    Metropolis,
}

/// What of a metric is learned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LearnMetric {
    /// Nothing.
    Fixed,
    /// A weight an input.
    #[default]
    Diagonal,
    /// All of it.
    Full,
}

impl Default for ProblemOptions {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            kernel: None,
            epsilon: None,
            smoothing: None,
            f32_error: F32_ERROR,
            degree: None,
            neighbors: None,
            centres: None,
            learn: None,
            weights: false,
            average: false,
            groups: None,
            neutral: 0,
            outside: QueryRule::Free,
            normalise: None,
            radius: None,
            normalise_features: false,
        }
    }
}

impl Default for Learn {
    fn default() -> Self {
        Self {
            method: LearnMethod::default(),
            centres: None,
            metric: LearnMetric::default(),
            rank: None,
            seeds: 4,
            evaluations: 1000,
            ridge: 1e-9,
        }
    }
}

impl LearnMethod {
    /// Returns the method with its numbers.
    pub fn method(self) -> hyper::Method {
        match self {
            Self::Projection => hyper::Method::VariableProjection,
            Self::Flow => hyper::Method::GradientFlow { step: 1e-2 },
            Self::Metropolis => hyper::Method::Metropolis { reach: 0.1, temperatures: [1e-3, 0.0] },
        }
    }
}

fn query_rule<'de, D: Deserializer<'de>>(from: D) -> Result<QueryRule, D::Error> {
    let name = String::deserialize(from)?;
    let found = QueryRule::ALL.into_iter().find(|rule| rule.name() == name);
    found.ok_or_else(|| D::Error::custom(expected(QueryRule::ALL.map(QueryRule::name), &name)))
}

fn normalise<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Normalise>, D::Error> {
    let name = String::deserialize(from)?;
    let found = Normalise::ALL.into_iter().find(|rule| rule.name() == name);
    let unknown = || D::Error::custom(expected(Normalise::ALL.map(Normalise::name), &name));
    found.map(Some).ok_or_else(unknown)
}

fn expected<const N: usize>(names: [&str; N], found: &str) -> String {
    format!("expected one of {}, found \"{found}\"", names.join(", "))
}
