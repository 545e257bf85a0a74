//! `sinew signal train` and `fit`: from a signal to a filter, and from observations to a function, in a file.

use super::process::ProcessArguments;
use crate::bake::bake;
use crate::cli::{OfFile, Output, OutputFile, Report, Run, count};
use crate::scattered;
use crate::signal::choose::variance;
use crate::signal::model::{self, FilterModel, LeftOut};
use crate::signal::observations::{Observations, function};
use crate::signal::sum::{Remedy, samples_remedy};
use crate::signal::table::read_signal;
use anyhow::bail;
use serde_json::json;
use sinew_runtime::format::Space;
use std::path::PathBuf;

/// Learns a filter from a signal that makes signals of its kind finer
///
/// The command learns the covariance of samples by their distance.
///
/// SIGNAL is CSV: a line of names, then a line for each sample. Every fine sample is a weighted sum of the coarse
/// samples in a window. The runtime reads the weights from MODEL.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew signal train sensor.csv --column angle --factor 4 -o sensor.sinew"
)]
pub(in crate::cli) struct Train {
    /// Signal: .csv
    signal: PathBuf,
    /// Column of the signal
    #[arg(long, value_name = "NAME")]
    column: String,
    /// Number of fine samples for each coarse sample
    #[arg(long, value_name = "F", value_parser = count(1, u16::MAX.into()))]
    factor: usize,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Write the variance of each fine sample too
    #[arg(long)]
    variance: bool,
    #[command(flatten)]
    process: ProcessArguments,
}

impl Run for Train {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let &Self { ref signal, ref column, factor, .. } = self;
        let target = OutputFile::new(&self.output, [signal])?.of_a_model()?;
        let samples = read_signal(signal, column).of(signal)?;
        match samples_remedy(&samples) {
            Some(remedy @ Remedy::Units) => bail!("{}: {remedy}", signal.display()),
            Some(remedy) => output.warn(signal.display(), format!("in single precision {remedy}")),
            None => {}
        }
        let sample = self.process.sample();
        let process = self.process.process(&samples, signal, output)?;
        let filter = self.process.filter(&process, factor, sample).of(signal)?;
        let fit = LeftOut::new(&samples, &process, filter.grid).of(signal)?;
        let rest = fit.map_or(0, |fit| fit.rest);
        if rest > 0 {
            let text =
                format!("samples at the end that fill no box of {factor} are not measured: {rest}");
            output.warn(signal.display(), text);
        }
        if let Some(LeftOut { rms, linear_rms, .. }) = fit.filter(|fit| fit.rms > fit.linear_rms) {
            let text = format!(
                "the filter predicts samples left out worse than lines between samples do, {rms:.4e} against \
                 {linear_rms:.4e}: lines are the better choice, or another --covariance or --mean"
            );
            output.warn(signal.display(), text);
        }
        let variance = variance(&samples, sample, &process.covariance);
        let model = FilterModel { name: column.clone(), filter, variance, fit };
        let bytes = bake(Space::default(), &[model::part(&model, self.variance)?])?;
        let report = Report::default()
            .figure("name", "filter", column, "")
            .figure("samples", "samples", samples.len(), "")
            .figure("covariance", "covariance", process.covariance.describe(), "")
            .json("variance", variance)
            .figure("deviation", "deviation", variance.sqrt(), "")
            .figure("factor", "phases", factor, "")
            .figure("taps", "taps of a phase", model.filter.grid.taps, "");
        let report = match fit {
            Some(fit) => report.part(
                "left_out",
                Report::default()
                    .figure("rms", "samples left out, RMS error", fit.rms, "")
                    .figure("linear_rms", "by lines between samples", fit.linear_rms, "")
                    .json("rest", fit.rest),
            ),
            None => report.shown("left_out", "samples left out", json!(null), "too few to measure"),
        };
        report.write(&target, &bytes)
    }
}

/// Finds a function from values, derivatives and averages
///
/// The function is the likeliest function of one number. It is baked as a kernel, for `sinew kernel eval` and the
/// runtime.
///
/// OBSERVATIONS is JSON with `observations`: {"at": x, "value": y}, {"at": x, "derivative": y} or {"from": a, "to": b,
/// "average": y}. It may have `name`, `covariance` ("squared exponential:LENGTH" and others; default: the likeliest),
/// `mean` (zero, constant, linear), `noise`, `variance` and `f32_error`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew signal fit spring.json -o spring.sinew")]
pub(in crate::cli) struct Fit {
    /// Observations: .json
    observations: PathBuf,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Allowed error of the file's single precision, as a share of the function's range [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    f32_error: Option<f64>,
}

impl Run for Fit {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let path = &self.observations;
        let target = OutputFile::new(&self.output, [path])?.of_a_model()?;
        let observations = Observations::read(path, self.f32_error).of(path)?;
        let fit = observations.fit().of(path)?;
        let (model, deviation) = function(&observations, &fit).of(path)?;
        let bytes = bake(Space::default(), &[scattered::bake::part(&model)?])?;
        let repeated = observations.repeated;
        if repeated > 0 {
            let text = format!(
                "observations that repeat earlier ones, or follow from them, and are left out: {repeated}"
            );
            output.warn(path.display(), text);
        }
        let variance = observations.variance(&fit);
        Report::default()
            .figure("name", "function", &model.name, "")
            .figure("observations", "observations", observations.values.len(), "")
            .figure("covariance", "covariance", observations.process.covariance.describe(), "")
            .json("variance", variance)
            .figure("deviation", "deviation", variance.sqrt(), "")
            .figure("centres", "centres", model.sum.centres.ncols(), "")
            .figure("residual_rms", "error at the observations, RMS", model.fit.residual_rms, "")
            .figure("bound", "error of f32, bound", model.fit.bound, "")
            .figure("f32_error", "error of f32, share of the range", deviation, "")
            .write(&target, &bytes)
    }
}
