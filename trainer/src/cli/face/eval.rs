//! `sinew face eval` and `report`: accuracy of a few handles, as a table or as a page.

use super::input;
use crate::cli::{ModelArgs, OfFile, Output, OutputFile, Report, Run, count, table};
use crate::face::baked::BakedFace;
use crate::face::evaluate::{Evaluation, Protocol};
use crate::face::outline;
use crate::face::picture::Photographer;
use crate::face::report;
use anyhow::bail;
use std::ops::Range;
use std::path::PathBuf;

/// Measures how near a few dragged landmarks bring a whole face
///
/// The command drags landmarks of MODEL to their positions in a take, and measures the distance of the whole face from
/// the take: with the prior, and with the slider norm, in which weights are independent. Lengths are in the face's
/// unit.
///
/// Handles are drawn ten times from the face's landmarks. The slider norm and the prior each use their best tolerance
/// on the frames that --frames leaves out.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew face eval head.sinew --animation other_take.csv --handles 3,8"
)]
pub(in crate::cli) struct Eval {
    #[command(flatten)]
    measured: Measured,
}

/// Face and take of a measurement.
#[derive(clap::Args)]
struct Measured {
    #[command(flatten)]
    model: ModelArgs,
    /// Weights of the face's shapes, frame by frame
    #[arg(long, value_name = "TAKE")]
    animation: PathBuf,
    /// 100 is a full shape in the take, and not 1
    #[arg(long)]
    percent: bool,
    /// Numbers of landmarks to drag
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [3, 5, 8, 12])]
    handles: Vec<usize>,
    /// Measure every Nth frame
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = count(1, 1_000_000))]
    every: usize,
    /// First frame to measure, counted from the first of --frames
    #[arg(long, value_name = "FRAME", default_value_t = 20)]
    from: usize,
    /// Frames of the take [default: all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    frames: Option<[Option<usize>; 2]>,
    /// Vertices to measure [default: the face's first region, or all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    vertices: Option<[Option<usize>; 2]>,
}

impl Run for Eval {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let evaluation = self.measured.measure(output, |_, evaluation| Ok(evaluation.clone()))?;
        Ok(Report::of(&evaluation).text(describe(&evaluation)))
    }
}

impl Measured {
    /// Measures a face, and calls `use_of` with the result.
    fn measure<T>(
        &self,
        output: Output,
        use_of: impl FnOnce(&Protocol<'_>, &Evaluation) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let model = self.model.load()?;
        let face = self.model.face(&model)?;
        let landmarks = self.model.outline(&face)?.landmarks;
        if landmarks.is_empty() {
            let file = self.model.file.display();
            bail!("{file}: the face has no landmarks: give them to `train` by --landmarks");
        }
        let [slider, slider_mean] = input::slider_models(&model, &face)?;
        let take = input::take(&self.animation, self.percent, &face.names(), output)?;
        let range = input::within(self.frames, take.file_len());
        let frames = take.pick(&range, self.from, self.every).of(&self.animation)?;
        let lost_frames = range.len() - take.every(&range, 0, 1).len();
        let left_out = [0..range.start, range.end..take.file_len()];
        let chosen_on = left_out.iter().map(|range| take.every(range, self.from, self.every));
        let protocol = Protocol {
            face,
            slider: self.model.face(&slider)?,
            slider_mean: self.model.face(&slider_mean)?,
            landmarks: &landmarks,
            vertices: self.vertices(&face)?,
            chosen_on: chosen_on.flatten().collect(),
            frames,
            lost_frames,
        };
        let evaluation = protocol.run(&self.handles).of(&self.model.file)?;
        use_of(&protocol, &evaluation)
    }

    /// Returns the vertices to measure.
    fn vertices(&self, face: &BakedFace<'_>) -> anyhow::Result<Range<usize>> {
        let len = face.skin.vertex_len();
        if self.vertices.is_none() {
            return Ok(face.skin.ranges().next().map_or(0..len, |(_, range)| range));
        }
        let range = input::within(self.vertices, len);
        if range.is_empty() || range.end > len {
            bail!("--vertices {}..{}: expected vertices within 0..{len}", range.start, range.end);
        }
        Ok(range)
    }
}

fn describe(evaluation: &Evaluation) -> String {
    let Evaluation { frames, chosen_on, landmarks, draws, vertices: [first, end], .. } = evaluation;
    let errors = evaluation.handles.iter().map(|(handles, row)| {
        let errors = [row.nothing, row.slider, row.slider_mean, row.prior, row.bounded];
        let errors = errors.map(|rms| format!("{rms:.4}"));
        std::iter::once(handles.to_string()).chain(errors).collect()
    });
    let mut methods = Vec::new();
    for (handles, row) in &evaluation.handles {
        for (name, figures) in &row.methods {
            methods.push(vec![
                format!("{handles} handles, {name}"),
                format!("{:.1e}", figures.beta.sqrt()),
                format!("{:.1}", figures.cardinality),
                format!("{:.4}", figures.roughness),
                format!("{:.1} %", 100.0 * figures.outside),
            ]);
        }
    }
    methods.push(vec![
        "the take".to_owned(),
        "-".to_owned(),
        format!("{:.1}", evaluation.take_cardinality),
        format!("{:.4}", evaluation.take_roughness),
    ]);
    format!(
        "{frames} frames, vertices {first}..{end}; handles from {landmarks} landmarks, mean of {draws} draws; tolerances \
         chosen on {chosen_on} other frames\n{}{}",
        table(
            &["handles", "nothing", "slider", "slider, mean", "prior", "bounded"],
            errors.collect()
        ),
        table(&["method", "tolerance", "cardinality", "roughness", "outside 0..1"], methods)
    )
}

/// Writes a page that shows how near a few handles bring a face
///
/// The page shows expressions of a take by a few handles, with the prior and with the slider norm side by side, their
/// errors, and a drag. It is one HTML file.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew face report head.sinew --animation other_take.csv -o report.html"
)]
pub(in crate::cli) struct ReportArgs {
    /// Page to write
    #[arg(short, long, alias = "out", value_name = "PAGE")]
    output: PathBuf,
    /// Width of a picture in pixels
    #[arg(long, default_value_t = 380, value_parser = count(16, 4096))]
    width: usize,
    #[command(flatten)]
    measured: Measured,
}

impl Run for ReportArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let Self { measured, output: page, width } = self;
        let (face_file, take) = (&measured.model.file, &measured.animation);
        let taken = [face_file.clone(), outline::beside(face_file), take.clone()];
        let target = OutputFile::new(page, &taken)?.of_a_report()?;
        let model = measured.model.load()?;
        let outline = measured.model.outline(&measured.model.face(&model)?)?;
        let mesh = outline.faces().of(&measured.model.file)?;
        let space = model.space();
        let (html, evaluation) = measured.measure(output, |protocol, evaluation| {
            let vertices = protocol.vertices.clone();
            let photographer = Photographer::new(&protocol.face, &space, mesh, vertices, *width);
            let take = take.file_name().unwrap_or_default().to_string_lossy();
            let page =
                report::Report { protocol, evaluation, photographer: &photographer, take: &take };
            Ok((page.html().of(&measured.model.file)?, evaluation.clone()))
        })?;
        Report::of(&evaluation).write(&target, html.as_bytes())
    }
}
