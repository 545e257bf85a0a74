//! `sinew signal train`: from a signal to a filter in a file.

use super::options::{ProcessArguments, sample};
use crate::cli::files::{OutputFile, write};
use crate::cli::{Output, counted, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::signal::choose::variance;
use sinew_trainer::signal::error::Remedy;
use sinew_trainer::signal::model::part;
use sinew_trainer::signal::model::{FilterModel, LeftOut};
use sinew_trainer::signal::sum::samples_remedy;
use sinew_trainer::signal::table::read_signal;
use std::path::PathBuf;

/// Learns a filter from a signal that makes signals of its kind finer
///
/// It learns how alike samples are by their distance.
///
/// SIGNAL is CSV: a line of names, then a sample a line. Every fine sample is a sum of the coarse samples of a window,
/// by weights that the runtime reads from MODEL.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// The signal: .csv
    signal: PathBuf,
    /// The column that is the signal
    #[arg(long, value_name = "NAME")]
    column: String,
    /// Fine samples of each coarse one
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u16).range(1..))]
    factor: u16,
    /// The file to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// Samples are means over the time between them, not values
    #[arg(long)]
    averages: bool,
    /// Also writes the variance of each fine sample
    #[arg(long)]
    variance: bool,
    #[command(flatten)]
    process: ProcessArguments,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { signal, column, averages, .. } = arguments;
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(signal))?.of_a_model()?;
    let about = || signal.display().to_string();
    let samples = read_signal(signal, column).with_context(about)?;
    match samples_remedy(&samples) {
        Some(remedy @ Remedy::Units) => bail!("{}: {remedy}", about()),
        Some(remedy) => output.warn(about(), format!("in single precision {remedy}")),
        None => {}
    }
    let (sample, factor) = (sample(*averages), usize::from(arguments.factor));
    let process =
        arguments.process.process(&samples, sample, output, &about()).with_context(about)?;
    let filter = arguments.process.filter(&process, factor, sample).with_context(about)?;
    let fit = LeftOut::new(&samples, &process, filter.grid).with_context(about)?;
    let rest = fit.map_or(0, |fit| fit.rest);
    if rest > 0 {
        let what =
            format!("samples at the end that fill no box of {factor} are not measured: {rest}");
        output.warn(about(), what);
    }
    if let Some(LeftOut { rms, linear_rms, .. }) = fit.filter(|fit| fit.rms > fit.linear_rms) {
        let what = format!(
            "the filter predicts samples left out worse than lines between samples do, {rms:.4e} against {linear_rms:.4e}: \
             lines are the better choice, or another --covariance or --mean"
        );
        output.warn(about(), what);
    }
    let variance = variance(&samples, sample, &process.covariance);
    let model = FilterModel { name: column.clone(), filter, variance, fit };
    let bytes = bake(Space::default(), &[part(&model, arguments.variance)?])?;
    write(&[(&target, &bytes)])?;
    let (covariance, taps) = (process.covariance.describe(), model.filter.grid.taps);
    let mut text = format!(
        "{}: {}, covariance {covariance}, deviation {:.4}, {} of {taps} taps\n",
        printable(column),
        counted(samples.len(), "sample", "samples"),
        variance.sqrt(),
        counted(factor, "phase", "phases"),
    );
    text += &match fit {
        Some(LeftOut { rms, linear_rms, .. }) => {
            format!(
                "samples left out, RMS error         {rms:.4e} (by lines between samples: {linear_rms:.4e})\n"
            )
        }
        None => "samples left out                    too few to tell\n".to_owned(),
    };
    text += &format!("{}: {} bytes\n", target.named().display(), bytes.len());
    let json = json!({
        "bytes": bytes.len(),
        "samples": samples.len(),
        "covariance": covariance,
        "variance": variance,
        "factor": factor,
        "taps": taps,
        "left_out": fit.map(|fit| json!({ "rms": fit.rms, "linear_rms": fit.linear_rms, "rest": fit.rest })),
    });
    output.print(&json, &text)
}
