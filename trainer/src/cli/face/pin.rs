//! `sinew face pin`: a few dragged points, and the face that follows.

use super::input::{self, ANCHORS};
use super::pins::{self, Followed, PinArgument, Placed, Projection};
use crate::cli::{
    ModelArgs, OfFile, Output, OutputFile, POSITIVE, Report, Run, count, files, named, number,
    table,
};
use crate::face::baked::{BakedFace, Shaped};
use crate::face::outline::{self, Outline};
use crate::face::picture::{Paint, Photographer};
use crate::face::scene::{Weights, glb};
use crate::face::take;
use anyhow::Context;
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::prior::{Anchor, Edit, PinJob};
use std::path::PathBuf;

/// Drags vertices of a face and lets the rest follow as in the take
///
/// The file is the mesh (.obj), the mesh with its shapes and weights (.glb), a picture (.png), or the weights (.csv).
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew face pin head.sinew --pin 5708=-3.1,_,9.9 --bounded -o smile.png"
)]
pub(in crate::cli) struct Pin {
    #[command(flatten)]
    model: ModelArgs,
    /// Vertex and its target, with _ for a free coordinate and *STIFFNESS for its weight among others; repeatable
    ///
    /// Two numbers are a position on a screen: VERTEX=X,Y.
    #[arg(long = "pin", value_name = "VERTEX=X,Y,Z", value_parser = pins::pin, allow_hyphen_values = true)]
    pins: Vec<PinArgument>,
    /// Vertex that keeps its position; repeatable
    #[arg(long, value_name = "VERTEX")]
    hold: Vec<u32>,
    /// File to write: .obj, .glb, .png or .csv
    #[arg(short, long, alias = "out", value_name = "OUT")]
    output: PathBuf,
    /// Width of a picture in pixels
    #[arg(long, default_value_t = 900, value_parser = count(16, 8192))]
    width: usize,
    /// Screen of pins with two numbers: two rows of four numbers, multiplied with (x, y, z, 1) [default: pixels of the
    /// .png picture, from its upper left]
    #[arg(long, value_name = "ROWS", value_parser = pins::projection, allow_hyphen_values = true)]
    projection: Option<Projection>,
    #[command(flatten)]
    solve: SolveArgs,
}

/// Options of a solve.
#[derive(clap::Args)]
#[command(next_help_heading = "Solve")]
struct SolveArgs {
    /// Current weights: the first row of a .csv [default: all 0]
    #[arg(long, value_name = "WEIGHTS")]
    weights: Option<PathBuf>,
    /// 100 is a full shape in WEIGHTS, and not 1
    #[arg(long, requires = "weights")]
    percent: bool,
    /// Keep weights between 0 and 1
    #[arg(long)]
    bounded: bool,
    /// Weights to stay near to: the current weights, or the mean of the take
    #[arg(long, value_parser = named(ANCHORS), default_value = "current")]
    anchor: Anchor,
    /// Use independent weights (the slider norm), for comparison with the learned prior
    #[arg(long)]
    slider: bool,
    /// Length by which a pin may miss [default: from the training]
    #[arg(long, value_name = "LENGTH", value_parser = number(POSITIVE, ""))]
    tolerance: Option<f64>,
}

/// Result of a solve.
struct Solved {
    weights: Vec<f32>,
    shaped: Shaped,
    edit: Edit,
    pins: Vec<Followed>,
}

impl Run for Pin {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let path = &self.model.file;
        let target = OutputFile::new(&self.output, &[path.clone(), outline::beside(path)])?;
        let ending = files::ending(&self.output, &["obj", "glb", "png", "csv"])?;
        let model = self.model.load()?;
        let face = self.model.face(&model)?;
        let is_slider = self.solve.slider;
        let sliders = is_slider.then(|| input::slider_models(&model, &face)).transpose()?;
        let solver = match (&sliders, self.solve.anchor) {
            (Some([_, slider_mean]), Anchor::Mean) => self.model.face(slider_mean)?,
            (Some([slider, _]), _) => self.model.face(slider)?,
            (None, _) => face,
        };
        let solved = self.solve(&solver, &face, &model, output).of(&self.model.file)?;
        let bytes = match ending {
            "csv" => {
                let weights = solved.weights.iter().copied().map(f64::from).collect();
                take::to_csv(&face.names(), &[(0, weights)])?
            }
            ending => self.draw(&face, &model, &solved, ending).of(&self.model.file)?,
        };
        report(&face, &solved, output).write(&target, &bytes)
    }
}

impl Pin {
    fn solve(
        &self,
        solver: &BakedFace<'_>,
        face: &BakedFace<'_>,
        model: &Model<Vec<u8>>,
        output: Output,
    ) -> anyhow::Result<Solved> {
        let SolveArgs { weights: file, percent, bounded, anchor, tolerance, .. } = &self.solve;
        let screen = || match self.projection {
            Some(projection) => Ok(projection),
            None => Ok(self.photographer(face, model, &self.model.outline(face)?)?.projection()),
        };
        let mut weights = vec![0.0; solver.skin.shape_len()];
        if let Some(path) = file {
            let take = input::take(path, *percent, &solver.names(), output)?;
            let first = take.frames.first().into_iter().flatten();
            weights.iter_mut().zip(first).for_each(|(out, weight)| *out = *weight as f32);
        }
        let before = solver.shaped(&weights)?;
        let len = solver.skin.vertex_len();
        let mut placed = Vec::new();
        for argument in &self.pins {
            placed.push(argument.place(len, screen)?);
        }
        for &vertex in &self.hold {
            let place = before.positions.get(vertex as usize).with_context(|| {
                format!("--hold {vertex}: expected a vertex from 0 to {}", len - 1)
            })?;
            placed.push(Placed::hold(vertex, *place));
        }
        let mut options = PinJob { anchor: *anchor, is_bounded: *bounded, ..solver.edit() };
        if let Some(tolerance) = tolerance {
            options.beta = (tolerance * tolerance) as f32;
        }
        let pins: Vec<_> = placed.iter().map(|placed| placed.pin).collect();
        let edit = solver.solve(&pins, &options, &mut Vec::new(), &mut weights)?;
        let shaped = solver.shaped(&weights)?;
        let pins = placed.iter().map(|placed| placed.follow(&shaped)).collect::<Result<_, _>>()?;
        Ok(Solved { weights, shaped, edit, pins })
    }

    fn draw(
        &self,
        face: &BakedFace<'_>,
        model: &Model<Vec<u8>>,
        solved: &Solved,
        ending: &str,
    ) -> anyhow::Result<Vec<u8>> {
        let outline = self.model.outline(face)?;
        Ok(match ending {
            "obj" => outline.moved(&solved.shaped.positions).into_bytes(),
            "glb" => glb(face, outline.faces()?, &Weights::Still(&solved.weights))?,
            _ => {
                let camera = self.photographer(face, model, &outline)?;
                let pins: Vec<_> = solved.pins.iter().map(|pin| pin.places).collect();
                camera.take(&solved.shaped, &Paint::Clay, &pins).png()?
            }
        })
    }

    fn photographer<'a>(
        &self,
        face: &BakedFace<'_>,
        model: &Model<Vec<u8>>,
        outline: &'a Outline,
    ) -> anyhow::Result<Photographer<'a>> {
        let whole = 0..face.skin.vertex_len();
        Ok(Photographer::new(face, &model.space(), outline.faces()?, whole, self.width))
    }
}

/// Reports a solve. The table has weights above 0.01, largest first.
fn report(face: &BakedFace<'_>, solved: &Solved, output: Output) -> Report {
    let Edit { norm, unreachable_len, is_least, .. } = solved.edit;
    let (len, free_len) = (solved.pins.len(), solved.pins.iter().filter(|pin| pin.is_free).count());
    // The runtime counts free pins too.
    let unreachable_len = unreachable_len.saturating_sub(free_len);
    if free_len > 0 {
        output.note("pins", format_args!("{free_len} of {len} are free in every coordinate"));
    }
    if unreachable_len > 0 {
        let text = format_args!("{unreachable_len} of {len} are where no shape moves anything");
        output.warn("pins", text);
    }
    let pin = |pin: &Followed| {
        Report::default()
            .figure("vertex", "vertex", pin.vertex, "")
            .json("at", &pin.at)
            .json("target", &pin.target)
            .figure("missed", "misses its target by", pin.missed(), "")
    };
    let mut weights: Vec<_> =
        face.names().into_iter().zip(solved.weights.iter().copied()).collect();
    let named: serde_json::Map<_, _> =
        weights.iter().map(|(name, weight)| (name.clone(), json!(weight))).collect();
    weights.retain(|(_, weight)| weight.abs() > 0.01);
    weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let rows = weights.into_iter().map(|(name, weight)| vec![name, format!("{weight:.3}")]);
    Report::default()
        .list("pins", solved.pins.iter().map(pin))
        .json("weights", named)
        .text(table(&["shape", "weight"], rows.collect()))
        .figure("norm", "norm of the edit", norm, "")
        .json("unreachable", unreachable_len)
        .json("least", is_least)
}
