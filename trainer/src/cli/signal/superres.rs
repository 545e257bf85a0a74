//! `sinew signal superres`: an image or a signal made finer.

use super::options::{ProcessArguments, sample};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, input, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::filter::Samples;
use sinew_trainer::signal::choose::variance;
use sinew_trainer::signal::grid::{Sample, Shape};
use sinew_trainer::signal::image::Image;
use sinew_trainer::signal::sum::samples_remedy;
use sinew_trainer::signal::table::read_signal;
use std::path::{Path, PathBuf};

/// Makes an image (.png) or a column of a CSV finer
///
/// Pixels are taken for means over their area and give themselves back: the mean of those made of one is that one.
/// Samples of a CSV are values, which stay where they are, unless they are said to be averages.
#[derive(clap::Args)]
#[command(after_help = "\
It is a linear filter, the best one if the covariance is right: sharper than bicubic, and far below what neural \
networks invent.")]
pub(in crate::cli) struct Arguments {
    /// What to make finer: .png or .csv
    input: PathBuf,
    /// Fine samples of each coarse one, along each side
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u16).range(1..=64))]
    #[arg(required_unless_present = "model")]
    factor: Option<u16>,
    /// The file to write, of the same kind
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// The column of a CSV
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// Samples of a CSV are means over the time between them, not values
    #[arg(long)]
    averages: bool,
    /// Also writes the variance of each sample of a CSV
    #[arg(long)]
    variance: bool,
    /// Takes the filter of a file that `sinew signal train` wrote, and the runtime
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["factor", "covariance", "mean", "noise", "taps"])]
    model: Option<PathBuf>,
    #[command(flatten)]
    process: ProcessArguments,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let path = &arguments.input;
    let mut taken = vec![path.clone()];
    taken.extend(arguments.model.clone());
    let target = OutputFile::new(&arguments.out, &taken)?;
    let kind = ending(path, &["png", "csv"])?;
    ending(&arguments.out, &[kind])?;
    let (bytes, json, text) = match kind {
        "png" => image(arguments, output)?,
        _ => signal(arguments, output)?,
    };
    write(&[(&target, &bytes)])?;
    output.print(&json, &format!("{}: {text}\n", target.named().display()))
}

/// Bytes of a file, and what is said of it.
type Made = (Vec<u8>, serde_json::Value, String);

fn image(arguments: &Arguments, output: Output) -> anyhow::Result<Made> {
    if arguments.column.is_some() || arguments.variance || arguments.averages {
        bail!("--column, --variance and --averages are of a .csv");
    }
    let about = || arguments.input.display().to_string();
    let coarse = Image::read(&arguments.input)?;
    let fine = match &arguments.model {
        Some(model) => by_model(&coarse, model)?,
        None => {
            let process = arguments.process.process_of_images(output)?;
            let filter = arguments.process.filter(&process, factor(arguments), Sample::Average)?;
            coarse.finer(&filter).with_context(about)?
        }
    };
    let fine = fine.within(fine.width / coarse.width)?;
    let Image { width, height, .. } = fine;
    let json = json!({ "width": width, "height": height });
    Ok((fine.png()?, json, format!("{width} x {height} pixels")))
}

/// Makes an image finer by a file's filter, in the runtime.
fn by_model(coarse: &Image, path: &Path) -> anyhow::Result<Image> {
    let about = || path.display().to_string();
    let model = load(path)?;
    let filter = model.filter().with_context(|| no_filter(path))?;
    let Image { width, height, channels, .. } = *coarse;
    let factor = filter.factor();
    let narrow: Vec<f32> = coarse.samples.iter().map(|x| *x as f32).collect();
    let mut tall = vec![0.0; narrow.len() * factor];
    let columns = Samples { signal_len: 1, sample_len: height, lane_len: width * channels };
    filter.apply(columns, &narrow, &mut tall).with_context(about)?;
    let mut fine = vec![0.0; tall.len() * factor];
    let rows = Samples { signal_len: height * factor, sample_len: width, lane_len: channels };
    filter.apply(rows, &tall, &mut fine).with_context(about)?;
    let samples = fine.iter().map(|x| f64::from(*x)).collect();
    Ok(Image { width: factor * width, height: factor * height, samples, ..coarse.clone() })
}

fn signal(arguments: &Arguments, output: Output) -> anyhow::Result<Made> {
    let about = || arguments.input.display().to_string();
    let column = arguments.column.as_ref().context("of a .csv --column NAME is needed")?;
    let samples = read_signal(&arguments.input, column).with_context(about)?;
    let (sample, n) = (sample(arguments.averages), samples.len());
    let (fine, variances, factor) = match &arguments.model {
        Some(path) => {
            let model = load(path)?;
            let filter = model.filter().with_context(|| no_filter(path))?;
            if let Some(remedy) = samples_remedy(&samples) {
                output.warn(about(), format!("in single precision {remedy}"));
            }
            let narrow: Vec<f32> = samples.iter().map(|x| *x as f32).collect();
            let mut fine = vec![0.0; n * filter.factor()];
            filter.apply(Samples::of_signal(n), &narrow, &mut fine).with_context(about)?;
            let of = |at: usize| {
                filter.variance(filter.window(at / filter.factor(), n).1, at % filter.factor())
            };
            let variances: Option<Vec<f64>> =
                (0..fine.len()).map(|at| of(at).map(f64::from)).collect();
            if arguments.variance && variances.is_none() {
                bail!("{}: it holds no variance: train it with --variance", path.display());
            }
            (
                fine.iter().map(|x| f64::from(*x)).collect(),
                variances.unwrap_or_default(),
                filter.factor(),
            )
        }
        None => {
            let process = arguments
                .process
                .process(&samples, sample, output, &about())
                .with_context(about)?;
            let filter = arguments.process.filter(&process, factor(arguments), sample)?;
            let fine =
                filter.apply(&samples, Shape { samples: n, lanes: 1 }).with_context(about)?;
            let scale = variance(&samples, sample, &process.covariance);
            let variances = filter.variances_of(n).iter().map(|x| scale * x).collect();
            (fine, variances, filter.grid.factor)
        }
    };
    let middle = if arguments.averages { 0.5 } else { 0.0 };
    let mut rows = csv::Writer::from_writer(Vec::new());
    let head = ["sample", column].into_iter().chain(arguments.variance.then_some("variance"));
    rows.write_record(head)?;
    for (at, value) in fine.iter().enumerate() {
        let place = (at as f64 + middle) / factor as f64;
        let variance = variances.get(at).filter(|_| arguments.variance);
        let cells = [place, *value].into_iter().chain(variance.copied());
        rows.write_record(cells.map(|x| x.to_string()))?;
    }
    let text = format!("{} samples of {}", fine.len(), printable(column));
    let json = json!({ "samples": fine.len(), "factor": factor });
    Ok((rows.into_inner().map_err(|error| error.into_error())?, json, text))
}

/// Returns the factor that was asked for, which is there where no model is.
fn factor(arguments: &Arguments) -> usize {
    arguments.factor.map_or(1, usize::from)
}

fn load(path: &Path) -> anyhow::Result<Model<Vec<u8>>> {
    Model::from_bytes(input::read_model(path)?).with_context(|| path.display().to_string())
}

fn no_filter(path: &Path) -> String {
    format!("{}: it has no filter; `sinew signal train` makes one", path.display())
}
