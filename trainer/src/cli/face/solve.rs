//! `sinew face solve`: the weights of an animation from tracked points.

use super::input::ANCHORS;
use crate::cli::{
    ModelArgs, OfFile, Output, OutputFile, POSITIVE, Report, Run, ending, named, number,
};
use crate::face::baked::BakedFace;
use crate::face::evaluate::{cardinality, roughness};
use crate::face::outline;
use crate::face::scene::{Weights, glb};
use crate::face::{take, track};
use anyhow::Context;
use sinew_runtime::prior::{Anchor, PinJob, Temporal};
use std::path::PathBuf;

/// Finds the weights of an animation from tracked points
///
/// POINTS is a table with the columns frame, vertex, x, y, z and optionally stiffness, the weight of a point among
/// others.
///
/// Each frame stays near the frame before, mirrored shapes stay near each other, and only one of two shapes that undo
/// each other is used. --plain disables all of this.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew face solve head.sinew --track points.csv --noise 0.1 -o weights.csv"
)]
pub(in crate::cli) struct Solve {
    #[command(flatten)]
    model: ModelArgs,
    /// Points, frame by frame: .csv
    #[arg(long, value_name = "POINTS")]
    track: PathBuf,
    /// File to write: .csv with a column for each shape, or .glb with the animated face
    #[arg(short, long, alias = "out", value_name = "WEIGHTS")]
    output: PathBuf,
    /// Frames a second of a .glb
    #[arg(long, default_value_t = 30.0, value_parser = number(POSITIVE, " frames a second"))]
    fps: f64,
    #[command(flatten)]
    solve: SolveArgs,
}

/// Options of a solve.
#[derive(clap::Args)]
#[command(next_help_heading = "Solve")]
struct SolveArgs {
    /// Error of the points, a length [default: from the training]
    #[arg(long, value_name = "LENGTH", value_parser = number(POSITIVE, ""))]
    noise: Option<f64>,
    /// Stiffness of weights from a frame to the next: one over the square of their change
    #[arg(long, value_name = "STIFFNESS", default_value_t = 50.0, value_parser = number(0.0.., ""))]
    temporal: f64,
    /// Stiffness between mirrored shapes, as a share of the take's
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = number(0.0.., ""))]
    symmetry: f64,
    /// Weights to stay near to: the weights of the frame before, or the mean of the take
    #[arg(long, value_parser = named(ANCHORS), default_value = "mean")]
    anchor: Anchor,
    /// Solve each frame alone: without the terms between frames and shapes, and without bounds
    #[arg(long)]
    plain: bool,
}

impl Run for Solve {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let Self { model: file, track: points, output: out, .. } = self;
        let inputs = [file.file.clone(), outline::beside(&file.file), points.clone()];
        let target = OutputFile::new(out, &inputs)?;
        let is_glb = ending(out, &["csv", "glb"])? == "glb";
        let model = file.load()?;
        let face = self.model.face(&model)?;
        let track = track::read(points, face.skin.vertex_len()).of(points)?;
        let frames = solve(&face, &track, &self.solve).of(points)?;
        let wide: Vec<(usize, Vec<f64>)> = frames
            .iter()
            .map(|(frame, weights)| (*frame, weights.iter().copied().map(f64::from).collect()))
            .collect();
        let bytes = if is_glb {
            let at =
                |(frame, weights): &(usize, Vec<f32>)| (*frame as f64 / self.fps, weights.clone());
            let keys: Vec<_> = frames.iter().map(at).collect();
            glb(&face, self.model.outline(&face)?.faces()?, &Weights::Played(&keys))?
        } else {
            take::to_csv(&face.names(), &wide)?
        };
        let solved: Vec<Vec<f64>> = wide.into_iter().map(|(_, weights)| weights).collect();
        Report::default()
            .figure("frames", "frames", solved.len(), "")
            .figure("cardinality", "weights above 0.01 a frame", cardinality(&solved), "")
            .figure("roughness", "roughness", roughness(&solved), "")
            .write(&target, &bytes)
    }
}

fn solve(
    face: &BakedFace<'_>,
    track: &track::Track,
    arguments: &SolveArgs,
) -> anyhow::Result<Vec<(usize, Vec<f32>)>> {
    let mut last: Vec<f32> =
        (0..face.skin.shape_len()).filter_map(|shape| face.prior.mean(shape)).collect();
    let mut scratch = Vec::new();
    let mut out = Vec::new();
    for (&frame, pins) in track {
        let is_bounded = !arguments.plain;
        let mut options = PinJob { anchor: arguments.anchor, is_bounded, ..face.edit() };
        if let Some(noise) = arguments.noise {
            options.beta = (noise * noise) as f32;
        }
        if !arguments.plain {
            let stiffness = arguments.temporal as f32;
            options.temporal = Some(Temporal { weights: &last, stiffness });
            options.symmetry = arguments.symmetry as f32;
            options.cancels = true;
        }
        let mut weights = last.clone();
        face.solve(pins, &options, &mut scratch, &mut weights)
            .with_context(|| format!("frame {frame}"))?;
        last.clone_from(&weights);
        out.push((frame, weights));
    }
    Ok(out)
}
