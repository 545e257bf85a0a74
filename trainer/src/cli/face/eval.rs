//! `sinew face eval`: what a few handles reach.

use super::input::{self, TakeFile};
use crate::cli::Output;
use anyhow::{Context, bail};
use sinew_trainer::face::baked::BakedFace;
use sinew_trainer::face::evaluate::{Evaluation, Protocol};
use sinew_trainer::face::outline::Outline;
use std::ops::Range;
use std::path::PathBuf;

/// Measures how near a few dragged landmarks bring a whole face
///
/// It drags landmarks of FACE to their places in a take, and measures how far the whole face then is from the take. It
/// does so with the prior, and with the slider norm, in which weights are independent. Lengths are in the face's unit.
///
/// Handles are drawn ten times of the face's landmarks. The slider norm and the prior each use the tolerance that
/// serves them best on the frames that --frames leaves out.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    measured: Measured,
}

/// What is measured.
#[derive(clap::Args)]
pub(super) struct Measured {
    /// A file that `sinew face train` wrote
    pub(super) face: PathBuf,
    /// Weights of its shapes, frame by frame
    #[arg(long, value_name = "TAKE")]
    pub(super) animation: PathBuf,
    /// 100 is a full shape in the take, and not 1
    #[arg(long)]
    percent: bool,
    /// How many landmarks to drag
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [3, 5, 8, 12])]
    handles: Vec<usize>,
    /// Measure every so many frames
    #[arg(long, default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// The first frame to measure, counted from the range's first
    #[arg(long, default_value_t = 20)]
    from: usize,
    /// Frames of the take that are measured [default: all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    frames: Option<[Option<usize>; 2]>,
    /// Vertices that are measured [default: the face's first region, or all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    vertices: Option<[Option<usize>; 2]>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let evaluation = measure(&arguments.measured, output, |_, evaluation| Ok(evaluation.clone()))?;
    output.print(&evaluation, &table(&evaluation))
}

/// Measures, and hands what was measured, and on what, to `use_of`.
pub(super) fn measure<T>(
    arguments: &Measured,
    output: Output,
    use_of: impl FnOnce(&Protocol<'_>, &Evaluation) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    let path = &arguments.face;
    let model = input::load(path)?;
    let face = input::open(&model, path)?;
    let landmarks = Outline::read(path, face.skin.vertex_len())?.landmarks;
    if landmarks.is_empty() {
        bail!("{}: the face has no landmarks: give them to `train` by --landmarks", path.display());
    }
    let [slider, slider_mean] = input::slider_models(&model, &face)?;
    let file = TakeFile { path: &arguments.animation, is_percent: arguments.percent };
    let take = input::take(file, &face.names(), output)?;
    let about = || arguments.animation.display().to_string();
    let range = input::within(arguments.frames, take.file_len());
    let (from, every) = (arguments.from, arguments.every as usize);
    let frames = take.pick(&range, from, every).with_context(about)?;
    let lost_frames = range.len() - take.every(&range, 0, 1).len();
    let left_out = [0..range.start, range.end..take.file_len()];
    let chosen_on = left_out.iter().map(|range| take.every(range, from, every));
    let protocol = Protocol {
        face,
        slider: input::open(&slider, path)?,
        slider_mean: input::open(&slider_mean, path)?,
        landmarks: &landmarks,
        vertices: vertices(&face, arguments)?,
        chosen_on: chosen_on.flatten().collect(),
        frames,
        lost_frames,
    };
    let evaluation =
        protocol.run(&arguments.handles).with_context(|| path.display().to_string())?;
    use_of(&protocol, &evaluation)
}

/// Gives the vertices to measure.
fn vertices(face: &BakedFace<'_>, arguments: &Measured) -> anyhow::Result<Range<usize>> {
    let len = face.skin.vertex_len();
    if arguments.vertices.is_none() {
        return Ok(face.skin.ranges().next().map_or(0..len, |(_, range)| range));
    }
    let range = input::within(arguments.vertices, len);
    if range.is_empty() || range.end > len {
        bail!("--vertices {}..{}: expected vertices within 0..{len}", range.start, range.end);
    }
    Ok(range)
}

fn table(evaluation: &Evaluation) -> String {
    let Evaluation { frames, chosen_on, landmarks, draws, vertices: [first, end], .. } = evaluation;
    let mut text = format!(
        "{frames} frames, vertices {first}..{end}; handles from {landmarks} landmarks, mean of {draws} draws; tolerances \
         chosen on {chosen_on} other frames\n"
    );
    let head = ["handles", "nothing", "slider", "slider, mean", "prior", "bounded"];
    let width = |column: usize| if column == 0 { 8 } else { 14 };
    for (column, name) in head.iter().enumerate() {
        text += &format!("{name:>0$}", width(column));
    }
    text += "\n";
    for (handles, row) in &evaluation.handles {
        text += &format!("{handles:>8}");
        for rms in [row.nothing, row.slider, row.slider_mean, row.prior, row.bounded] {
            text += &format!("{rms:>14.4}");
        }
        text += "\n";
    }
    text += &format!(
        "{:<24}{:>10}{:>14}{:>14}{:>14}\n",
        "", "tolerance", "cardinality", "roughness", "outside 0..1"
    );
    for (handles, row) in &evaluation.handles {
        for (name, figures) in &row.methods {
            text += &format!(
                "{:<24}{:>10.1e}{:>14.1}{:>14.4}{:>12.1} %\n",
                format!("{handles} handles, {name}"),
                figures.beta.sqrt(),
                figures.cardinality,
                figures.roughness,
                100.0 * figures.outside,
            );
        }
    }
    text + &format!(
        "{:<24}{:>10}{:>14.1}{:>14.4}\n",
        "the take", "", evaluation.take_cardinality, evaluation.take_roughness
    )
}
