//! `sinew signal plot`: a curve, its samples and how sure it is, as a picture.

use super::options::{ProcessArguments, sample};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, printable};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::signal::choose::variance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::grid::{Sample, Shape};
use sinew_trainer::signal::observations::Observations;
use sinew_trainer::signal::plot::SignalPlot;
use sinew_trainer::signal::table::read_signal;
use std::path::{Path, PathBuf};

/// Draws a signal or a function, with a band around it
///
/// The picture has the curve, the samples, and a band of two standard deviations.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A signal (.csv), or observations as `sinew signal fit` takes them (.json)
    input: PathBuf,
    /// The picture to write: .png or .svg
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// The column of a CSV
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// Points of the curve of each sample of a CSV
    #[arg(long, value_name = "F", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=64))]
    factor: u16,
    /// Samples of a CSV are means over the time between them, not values
    #[arg(long)]
    averages: bool,
    #[command(flatten)]
    process: ProcessArguments,
}

/// Points of the curve of a function, and how far beyond its observations it goes, over their range.
const POINTS: usize = 600;
const ROOM: f64 = 0.1;

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(&arguments.input))?;
    let is_svg = ending(&arguments.out, &["png", "svg"])? == "svg";
    let plot = match ending(&arguments.input, &["csv", "json"])? {
        "csv" => of_signal(arguments, output)?,
        _ => of_observations(&arguments.input)?,
    };
    let drawing = plot.draw();
    let bytes = if is_svg { drawing.svg()?.into_bytes() } else { drawing.picture().png()? };
    write(&[(&target, &bytes)])?;
    let place = target.named().display().to_string();
    output.print(&json!({ "points": plot.places.len(), "file": place }), &format!("{place}\n"))
}

fn of_signal(arguments: &Arguments, output: Output) -> anyhow::Result<SignalPlot> {
    let about = || arguments.input.display().to_string();
    let column = arguments.column.as_ref().context("of a .csv --column NAME is needed")?;
    let samples = read_signal(&arguments.input, column).with_context(about)?;
    let (sample, n) = (sample(arguments.averages), samples.len());
    let process =
        arguments.process.process(&samples, sample, output, &about()).with_context(about)?;
    let filter = arguments.process.filter(&process, arguments.factor.into(), sample)?;
    let values = filter.apply(&samples, Shape { samples: n, lanes: 1 }).with_context(about)?;
    let scale = variance(&samples, sample, &process.covariance);
    let middle = if sample == Sample::Average { 0.5 } else { 0.0 };
    let place = |at: usize| (at as f64 + middle) / f64::from(arguments.factor);
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
        deviations: filter.variances_of(n).iter().map(|x| (scale * x).sqrt()).collect(),
        samples: own,
        boxes,
    })
}

fn of_observations(path: &Path) -> anyhow::Result<SignalPlot> {
    let about = || path.display().to_string();
    let observations = Observations::read(path, None).with_context(about)?;
    let fit = observations.fit().with_context(about)?;
    let scale = observations.variance(&fit);
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
        title: format!(
            "{}, {}",
            printable(&observations.name),
            observations.process.covariance.describe()
        ),
        places,
        values: found.iter().map(|found| found.value).collect(),
        deviations: found.iter().map(|found| (scale * found.variance).sqrt()).collect(),
        samples,
        boxes,
    })
}
