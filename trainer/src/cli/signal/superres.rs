//! `sinew signal superres`: makes an image or a signal finer.

use super::process::ProcessArguments;
use crate::cli::{OfFile, Output, OutputFile, Report, Run, count, ending, load};
use crate::signal::grid::Sample;
use crate::signal::image::Image;
use crate::signal::sum::samples_remedy;
use crate::signal::table::read_signal;
use anyhow::{Context, bail};
use sinew_runtime::Filter;
use sinew_runtime::filter::Samples;
use std::path::{Path, PathBuf};

/// Makes an image (.png) or a column of a CSV finer
///
/// Pixels are means over their area, and are reproduced: the mean of the fine pixels in a coarse pixel is the coarse
/// pixel. Samples of a CSV are values, which keep their positions, unless --averages is given.
#[derive(clap::Args)]
#[command(after_help = "\
The filter is linear, and the best one if the covariance is right: sharper than bicubic, and far below the invention of \
neural networks.\n\nExample:\n  sinew signal superres in.png --factor 2 -o out.png")]
pub(in crate::cli) struct Superres {
    /// Image or signal: .png or .csv
    input: PathBuf,
    /// Number of fine samples for each coarse sample, along each side
    #[arg(long, value_name = "F", value_parser = count(1, 64), required_unless_present = "model")]
    factor: Option<usize>,
    /// File to write, of the same kind
    #[arg(short, long, alias = "out", value_name = "OUT")]
    output: PathBuf,
    /// Column of a CSV
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// Write the variance of each sample of a CSV too
    #[arg(long)]
    variance: bool,
    /// Take the filter of a file that `sinew signal train` wrote, evaluated by the runtime
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["factor", "covariance", "mean", "noise", "taps"])]
    model: Option<PathBuf>,
    #[command(flatten)]
    process: ProcessArguments,
}

impl Run for Superres {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let path = &self.input;
        let taken = [path].into_iter().chain(&self.model);
        let target = OutputFile::new(&self.output, taken)?;
        let kind = ending(path, &["png", "csv"])?;
        ending(&self.output, &[kind])?;
        let (bytes, report) = match kind {
            "png" => image(self, output)?,
            _ => signal(self, output)?,
        };
        report.write(&target, &bytes)
    }
}

/// Bytes of a file, and a report on the file.
type Made = (Vec<u8>, Report);

fn image(arguments: &Superres, output: Output) -> anyhow::Result<Made> {
    if arguments.column.is_some() || arguments.variance || arguments.process.averages {
        bail!("--column, --variance and --averages are for a .csv");
    }
    let coarse = Image::read(&arguments.input)?;
    let fine = match &arguments.model {
        Some(model) => by_model(&coarse, model)?,
        None => {
            let process = arguments.process.process_of_images(output)?;
            let factor = arguments.factor.unwrap_or(1);
            let filter = arguments.process.filter(&process, factor, Sample::Average)?;
            coarse.finer(&filter).of(&arguments.input)?
        }
    };
    let fine = fine.within(fine.width / coarse.width)?;
    let Image { width, height, .. } = fine;
    let report = Report::default().figure("width", "width", width, "pixels");
    Ok((fine.png()?, report.figure("height", "height", height, "pixels")))
}

/// Makes an image finer by the filter of a file, evaluated by the runtime.
fn by_model(coarse: &Image, path: &Path) -> anyhow::Result<Image> {
    let model = load(path)?;
    let filter = model.first::<Filter>().with_context(|| no_filter(path))?;
    let Image { width, height, channels, .. } = *coarse;
    let factor = filter.factor();
    let narrow: Vec<f32> = coarse.samples.iter().map(|x| *x as f32).collect();
    let mut tall = vec![0.0; narrow.len() * factor];
    let columns = Samples { signal_len: 1, sample_len: height, lane_len: width * channels };
    filter.apply(columns, &narrow, &mut tall).of(path)?;
    let mut fine = vec![0.0; tall.len() * factor];
    let rows = Samples { signal_len: height * factor, sample_len: width, lane_len: channels };
    filter.apply(rows, &tall, &mut fine).of(path)?;
    let samples = fine.iter().map(|x| f64::from(*x)).collect();
    Ok(Image { width: factor * width, height: factor * height, samples, ..coarse.clone() })
}

fn signal(arguments: &Superres, output: Output) -> anyhow::Result<Made> {
    let Superres { input, process: own, .. } = arguments;
    let column = arguments.column.as_ref().context("a .csv needs --column NAME")?;
    let samples = read_signal(input, column).of(input)?;
    let n = samples.len();
    let (fine, variances, factor): (Vec<f64>, Vec<f64>, usize) = match &arguments.model {
        Some(path) => {
            let model = load(path)?;
            let filter = model.first::<Filter>().with_context(|| no_filter(path))?;
            if let Some(remedy) = samples_remedy(&samples) {
                output.warn(input.display(), format!("in single precision {remedy}"));
            }
            let factor = filter.factor();
            let narrow: Vec<f32> = samples.iter().map(|x| *x as f32).collect();
            let mut fine = vec![0.0; n * factor];
            filter.apply(Samples::of_signal(n), &narrow, &mut fine).of(input)?;
            let variance = |at| filter.variance(filter.window(at / factor, n).1, at % factor);
            let variances: Option<Vec<f64>> =
                (0..fine.len()).map(|at| variance(at).map(f64::from)).collect();
            if arguments.variance && variances.is_none() {
                bail!("{}: it holds no variance: train it with --variance", path.display());
            }
            (fine.into_iter().map(f64::from).collect(), variances.unwrap_or_default(), factor)
        }
        None => {
            let factor = arguments.factor.unwrap_or(1);
            let (_, fine, variances) = own.finer(&samples, factor, input, output)?;
            (fine, variances, factor)
        }
    };
    let middle = if arguments.process.averages { 0.5 } else { 0.0 };
    let mut rows = csv::Writer::from_writer(Vec::new());
    let head = ["sample", column].into_iter().chain(arguments.variance.then_some("variance"));
    rows.write_record(head)?;
    for (at, value) in fine.iter().enumerate() {
        let place = (at as f64 + middle) / factor as f64;
        let variance = variances.get(at).filter(|_| arguments.variance);
        let cells = [place, *value].into_iter().chain(variance.copied());
        rows.write_record(cells.map(|x| x.to_string()))?;
    }
    let report = Report::default()
        .figure("column", "column", column, "")
        .figure("samples", "samples", fine.len(), "")
        .figure("factor", "for each coarse sample", factor, "");
    Ok((rows.into_inner().map_err(|error| error.into_error())?, report))
}

fn no_filter(path: &Path) -> String {
    format!("{}: it has no filter; `sinew signal train` makes one", path.display())
}
