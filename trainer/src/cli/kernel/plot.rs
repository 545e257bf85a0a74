//! `sinew kernel plot`: a function as a picture.

use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted, input, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::kernel::{InputKind, KernelMap, OutputKind};
use sinew_trainer::scattered::plot::{Panel, Plot, all_kernels};
use std::path::PathBuf;

/// Draws a function of one or two numbers, with its samples
///
/// Each output has a picture; the samples are the centres of the function.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew kernel train` wrote
    model: PathBuf,
    /// The picture to write: .png or .svg
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Draw all kernels side by side, each through the same samples, of the first output
    #[arg(long)]
    all: bool,
}

/// How far beyond the centres a picture goes, over their range.
const ROOM: f64 = 0.25;

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(&arguments.model))?;
    let is_svg = ending(&arguments.out, &["png", "svg"])? == "svg";
    let about = || arguments.model.display().to_string();
    let model = Model::from_bytes(input::read_model(&arguments.model)?).with_context(about)?;
    let map = model.kernels().next().with_context(|| format!("{}: it has no function", about()))?;
    let plot = plot(&map, arguments.all).with_context(about)?;
    let drawing = plot.draw();
    let bytes = if is_svg { drawing.svg()?.into_bytes() } else { drawing.picture().png()? };
    write(&[(&target, &bytes)])?;
    let (panels, place) = (plot.panels.len(), target.named().display());
    let json = json!({ "panels": panels, "file": place.to_string() });
    output.print(&json, &format!("{place}: {}\n", counted(panels, "picture", "pictures")))
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
        let scalars = scalars(map);
        let column = |numbers: &[Vec<f32>], at: usize| -> Vec<f64> {
            numbers.iter().map(|numbers| f64::from(numbers[at])).collect()
        };
        let panel = |(title, at): &(String, usize)| Panel {
            title: title.clone(),
            values: column(&found, *at),
            samples: column(&own, *at),
        };
        scalars.iter().map(panel).collect::<Vec<_>>()
    };
    let name = |input| printable(map.input_name(input).unwrap_or_default());
    Ok(Plot { inputs: (0..kinds.len()).map(name).collect(), domain, sites, panels })
}

/// Names each number of the outputs, and tells its place.
fn scalars(map: &KernelMap<'_>) -> Vec<(String, usize)> {
    let mut out = Vec::new();
    let mut place = 0;
    for (number, row) in map.outputs().enumerate() {
        let name = printable(map.output_name(number).unwrap_or_default());
        let len = row.kind.number_len();
        let title = |part: usize| match row.kind {
            OutputKind::Scalar => name.clone(),
            _ => format!("{name}.{}", ["x", "y", "z", "w"][part]),
        };
        out.extend((0..len).map(|part| (title(part), place + part)));
        place += len;
    }
    out
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
