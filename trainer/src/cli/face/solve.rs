//! `sinew face solve`: the weights of an animation from points that were followed.

use super::input::{self, AnchorName};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted};
use anyhow::Context;
use serde_json::json;
use sinew_runtime::prior::{Pin, Temporal};
use sinew_trainer::face::baked::{BakedFace, SolveOptions};
use sinew_trainer::face::evaluate::{cardinality, roughness};
use sinew_trainer::face::outline::{self, Outline};
use sinew_trainer::face::scene::{Weights, glb};
use sinew_trainer::face::{take, track};
use std::path::PathBuf;

/// Finds the weights of an animation from tracked points
///
/// POINTS is a table with the columns frame, vertex, x, y, z and, where some count more than others, stiffness.
///
/// Each frame stays near the one before it, mirrored shapes near each other, and of shapes that undo each other one
/// alone is at work; --plain leaves all that out.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew face train` wrote
    face: PathBuf,
    /// Points, frame by frame: .csv
    #[arg(long, value_name = "POINTS")]
    track: PathBuf,
    /// The file to write: .csv with a column a shape, or .glb with the face playing it
    #[arg(short, long, value_name = "WEIGHTS")]
    out: PathBuf,
    /// By what length points are off [default: that of the training]
    #[arg(long, value_name = "LENGTH", value_parser = input::length)]
    noise: Option<f64>,
    /// How stiff weights are from a frame to the next: one over the square by which they change
    #[arg(long, value_name = "STIFFNESS", default_value_t = 50.0, value_parser = input::stiffness)]
    temporal: f32,
    /// How much alike mirrored shapes are, in what the take says of them
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = input::stiffness)]
    symmetry: f32,
    /// What is changed as little as may be: the weights of the frame before, or the mean of the take
    #[arg(long, value_enum, default_value = "mean")]
    anchor: AnchorName,
    /// Each frame by itself: without the terms between frames and shapes, and without bounds
    #[arg(long)]
    plain: bool,
    /// Frames a second of a .glb
    #[arg(long, default_value_t = 30.0, value_parser = input::length)]
    fps: f64,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { face: path, track: points, out, .. } = arguments;
    let inputs = [path.clone(), outline::beside(path), points.clone()];
    let target = OutputFile::new(out, &inputs)?;
    let is_glb = ending(out, &["csv", "glb"])? == "glb";
    let model = input::load(path)?;
    let face = input::open(&model, path)?;
    let track = track::read(points, face.skin.vertex_len())
        .with_context(|| points.display().to_string())?;
    let frames = solve(&face, &track, arguments).with_context(|| points.display().to_string())?;
    let wide: Vec<(usize, Vec<f64>)> = frames
        .iter()
        .map(|(frame, weights)| (*frame, weights.iter().copied().map(f64::from).collect()))
        .collect();
    let bytes = if is_glb {
        let outline = Outline::read(path, face.skin.vertex_len())?;
        let at =
            |(frame, weights): &(usize, Vec<f32>)| (*frame as f64 / arguments.fps, weights.clone());
        let keys: Vec<_> = frames.iter().map(at).collect();
        glb(&face, outline.faces()?, &Weights::Played(&keys))?
    } else {
        take::to_csv(&face.names(), &wide)?
    };
    write(&[(&target, &bytes)])?;
    let solved: Vec<Vec<f64>> = wide.into_iter().map(|(_, weights)| weights).collect();
    let (cardinality, roughness) = (cardinality(&solved), roughness(&solved));
    let json = json!({
        "frames": solved.len(), "cardinality": cardinality, "roughness": roughness,
        "file": target.named().display().to_string(),
    });
    let text = format!(
        "{}; {cardinality:.1} weights above 0.01 in each, roughness {roughness:.3e}\nwrote {}\n",
        counted(solved.len(), "frame", "frames"),
        target.named().display()
    );
    output.print(&json, &text)
}

fn solve(
    face: &BakedFace<'_>,
    track: &track::Track,
    arguments: &Arguments,
) -> anyhow::Result<Vec<(usize, Vec<f32>)>> {
    let mut last: Vec<f32> =
        (0..face.skin.shape_len()).filter_map(|shape| face.prior.mean(shape)).collect();
    let mut scratch = Vec::new();
    let mut out = Vec::new();
    for (&frame, points) in track {
        let pin = |point: &track::Point| {
            let at = point.at.map(|x| x as f32);
            Pin::new(point.vertex as u32, at).with_stiffness(point.stiffness as f32)
        };
        let pins: Vec<Pin> = points.iter().map(pin).collect();
        let mut options =
            SolveOptions { anchor: arguments.anchor.anchor(), ..SolveOptions::edit(&face.prior) };
        if let Some(noise) = arguments.noise {
            options.beta = (noise * noise) as f32;
        }
        options.is_bounded = !arguments.plain;
        if !arguments.plain {
            let stiffness = arguments.temporal;
            options.temporal = Some(Temporal { weights: &last, stiffness });
            options.symmetry = arguments.symmetry;
            options.cancels = true;
        }
        let mut weights = last.clone();
        face.solve(&pins, &options, &mut scratch, &mut weights)
            .with_context(|| format!("frame {frame}"))?;
        last.clone_from(&weights);
        out.push((frame, weights));
    }
    Ok(out)
}
