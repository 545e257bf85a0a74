//! `sinew kernel plot`: a function as a picture.

use super::eval::columns;
use crate::cli::files::drawn;
use crate::cli::{ModelArgs, OfFile, Output, OutputFile, Report, Run, printable};
use crate::scattered::plot::{Panel, Plot, all_kernels};
use anyhow::{Context, bail};
use sinew_runtime::kernel::{InputKind, KernelMap};
use std::path::PathBuf;

/// Draws a function of one or two numbers, with its samples
///
/// Each output has a picture; the samples are the centres of the function.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew kernel plot wrist.sinew -o wrist.png")]
pub(in crate::cli) struct PlotArgs {
    #[command(flatten)]
    model: ModelArgs,
    /// Picture to write: .png or .svg
    #[arg(short, long, alias = "out", value_name = "OUT")]
    output: PathBuf,
    /// Draw the first output with every kernel, each through the same samples
    #[arg(long)]
    all: bool,
}

/// Margin of a picture beyond the centres, as a share of their range.
const ROOM: f64 = 0.25;

impl Run for PlotArgs {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let target =
            OutputFile::new(&self.output, [&self.model.file])?.ending_in(&["png", "svg"])?;
        let model = self.model.load()?;
        let map = model.all::<KernelMap>().next();
        let map =
            map.with_context(|| format!("{}: it has no function", self.model.file.display()))?;
        let plot = plot(&map, self.all).of(&self.model.file)?;
        let bytes = drawn(&plot.draw(), &self.output)?;
        let panels = plot.panels.len();
        Report::default().figure("panels", "pictures", panels, "").write(&target, &bytes)
    }
}

fn plot(map: &KernelMap<'_>, all: bool) -> anyhow::Result<Plot> {
    let kinds: Vec<InputKind> = map.inputs().map(|row| row.kind).collect();
    let counts = map.counts();
    let fits = matches!(kinds[..], [InputKind::Scalar] | [InputKind::Scalar, InputKind::Scalar]);
    if !fits || counts.metric_len > 0 {
        bail!(
            "only functions of one or two plain numbers can be drawn: no rotations, and no weighing of inputs against each other"
        );
    }
    let sites = sites(map);
    if sites.is_empty() {
        bail!("it has no centres to draw");
    }
    let range = |input: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for site in &sites {
            (low, high) = (low.min(site[input]), high.max(site[input]));
        }
        let room = if high > low { ROOM * (high - low) } else { 1.0 };
        [low - room, high + room]
    };
    let domain: Vec<[f64; 2]> = (0..kinds.len()).map(range).collect();
    let at = |points: &[Vec<f64>]| {
        points.iter().map(|x| evaluate(map, x)).collect::<Result<Vec<_>, _>>()
    };
    let (points, own) = (Plot::points(&domain), at(&sites)?);
    let panels = if all {
        let values: Vec<f64> = own.iter().map(|numbers| f64::from(numbers[0])).collect();
        let panel = |(kernel, values_at): (String, Vec<f64>)| Panel {
            title: kernel,
            values: values_at,
            samples: values.clone(),
        };
        all_kernels(&sites, &values, &points).into_iter().map(panel).collect()
    } else {
        let found = at(&points)?;
        let column = |numbers: &[Vec<f32>], at: usize| -> Vec<f64> {
            numbers.iter().map(|numbers| f64::from(numbers[at])).collect()
        };
        let panel = |(at, title): (usize, String)| Panel {
            title,
            values: column(&found, at),
            samples: column(&own, at),
        };
        columns(map).into_iter().enumerate().map(panel).collect::<Vec<_>>()
    };
    let name = |input| printable(map.input_name(input).unwrap_or_default());
    Ok(Plot { inputs: (0..kinds.len()).map(name).collect(), domain, sites, panels })
}

/// Returns the centres as inputs.
fn sites(map: &KernelMap<'_>) -> Vec<Vec<f64>> {
    let counts = map.counts();
    let input = |k: usize, i: usize| {
        let [shift, scale, ..] = map.feature(i).unwrap_or([0.0, 1.0, 0.0, 0.0]).map(f64::from);
        let centre = f64::from(map.centre(k, i).unwrap_or_default());
        if scale == 0.0 { shift } else { centre / scale + shift }
    };
    let inputs = counts.feature_len as usize;
    (0..counts.centre_len as usize).map(|k| (0..inputs).map(|i| input(k, i)).collect()).collect()
}

fn evaluate(map: &KernelMap<'_>, x: &[f64]) -> anyhow::Result<Vec<f32>> {
    let query: Vec<f32> = x.iter().map(|x| *x as f32).collect();
    let mut scratch = vec![0.0; map.counts().scratch_len()];
    let mut out = vec![0.0; map.result_len()];
    map.evaluate(&query, &mut scratch, &mut out)?;
    Ok(out)
}
