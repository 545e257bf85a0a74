//! `sinew signal plot`: a picture of a curve, its samples and its deviation.

use super::process::ProcessArguments;
use crate::cli::files::drawn;
use crate::cli::{OfFile, Output, OutputFile, Report, Run, count, ending, printable};
use crate::signal::functional::Functional;
use crate::signal::grid::Sample;
use crate::signal::observations::Observations;
use crate::signal::plot::SignalPlot;
use crate::signal::table::read_signal;
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Draws a signal or a function, with a band around it
///
/// The picture has the curve, the samples, and a band of two standard deviations.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew signal plot sensor.csv --column angle -o curve.svg")]
pub(in crate::cli) struct PlotArgs {
    /// Signal (.csv), or observations as for `sinew signal fit` (.json)
    input: PathBuf,
    /// Picture to write: .png or .svg
    #[arg(short, long, alias = "out", value_name = "OUT")]
    output: PathBuf,
    /// Column of a CSV
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// Number of points of the curve for each sample of a CSV
    #[arg(long, value_name = "F", default_value_t = 8, value_parser = count(1, 64))]
    factor: usize,
    #[command(flatten)]
    process: ProcessArguments,
}

/// Number of points of a function's curve.
const POINTS: usize = 600;
/// Margin beyond the observations, as a share of their range.
const ROOM: f64 = 0.1;

impl Run for PlotArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let target = OutputFile::new(&self.output, [&self.input])?.ending_in(&["png", "svg"])?;
        let plot = match ending(&self.input, &["csv", "json"])? {
            "csv" => of_signal(self, output)?,
            _ => of_observations(&self.input)?,
        };
        let bytes = drawn(&plot.draw(), &self.output)?;
        let points = plot.places.len();
        Report::default().figure("points", "points", points, "").write(&target, &bytes)
    }
}

fn of_signal(arguments: &PlotArgs, output: Output) -> anyhow::Result<SignalPlot> {
    let column = arguments.column.as_ref().context("a .csv needs --column NAME")?;
    let samples = read_signal(&arguments.input, column).of(&arguments.input)?;
    let sample = arguments.process.sample();
    let (process, values, variances) =
        arguments.process.finer(&samples, arguments.factor, &arguments.input, output)?;
    let middle = if sample == Sample::Average { 0.5 } else { 0.0 };
    let place = |at: usize| (at as f64 + middle) / arguments.factor as f64;
    let (mut own, mut boxes) = (Vec::new(), Vec::new());
    for (at, value) in samples.iter().enumerate() {
        match sample {
            Sample::Value => own.push([at as f64, *value]),
            Sample::Average => boxes.push([at as f64, at as f64 + 1.0, *value]),
        }
    }
    Ok(SignalPlot {
        title: format!("{}, {}", printable(column), process.covariance.describe()),
        places: (0..values.len()).map(place).collect(),
        values,
        deviations: variances.into_iter().map(f64::sqrt).collect(),
        samples: own,
        boxes,
    })
}

fn of_observations(path: &Path) -> anyhow::Result<SignalPlot> {
    let observations = Observations::read(path, None).of(path)?;
    let fit = observations.fit().of(path)?;
    let scale = observations.variance(&fit);
    let covariance = observations.process.covariance.describe();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut samples, mut boxes) = (Vec::new(), Vec::new());
    for (of, value) in observations.functionals.iter().zip(&observations.values) {
        let (from, to) = match *of {
            Functional::Value { at } => {
                samples.push([at, *value]);
                (at, at)
            }
            Functional::Derivative { at } => (at, at),
            Functional::Average { from, to } => {
                boxes.push([from, to, *value]);
                (from, to)
            }
        };
        (low, high) = (low.min(from), high.max(to));
    }
    let room = if high > low { ROOM * (high - low) } else { 1.0 };
    let step = (high - low + 2.0 * room) / (POINTS - 1) as f64;
    let places: Vec<f64> = (0..POINTS).map(|k| low - room + step * k as f64).collect();
    let found: Vec<_> = places.iter().map(|&at| fit.predict(&Functional::Value { at })).collect();
    Ok(SignalPlot {
        title: format!("{}, {covariance}", printable(&observations.name)),
        places,
        values: found.iter().map(|found| found.value).collect(),
        deviations: found.iter().map(|found| (scale * found.variance).sqrt()).collect(),
        samples,
        boxes,
    })
}
