//! `sinew face pin`: a few points dragged, and the face that follows.

use super::input::{self, AnchorName, TakeFile};
use super::pins::{self, Followed, PinArgument, Placed, Projection};
use crate::cli::Output;
use crate::cli::column::padded;
use crate::cli::files::{self, OutputFile, write};
use anyhow::Context;
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::prior::Edit;
use sinew_trainer::face::baked::{BakedFace, Shaped, SolveOptions};
use sinew_trainer::face::outline::{self, Outline};
use sinew_trainer::face::picture::{Paint, Photographer};
use sinew_trainer::face::scene::{Weights, glb};
use sinew_trainer::face::take;
use std::path::PathBuf;

/// Drags vertices of a face and lets the rest follow as in the take
///
/// Writes the mesh (.obj), the mesh with its shapes and weights (.glb), a picture (.png), or the weights (.csv).
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew face train` wrote
    face: PathBuf,
    /// A vertex and where it is to be, _ for a coordinate that is free, *STIFFNESS for how much it counts beside
    /// others; may be given several times
    ///
    /// Two numbers are a place on a screen: VERTEX=X,Y.
    #[arg(long = "pin", value_name = "VERTEX=X,Y,Z", value_parser = pins::pin, allow_hyphen_values = true)]
    pins: Vec<PinArgument>,
    /// The screen of pins with two numbers: two rows of four numbers, which a place (x, y, z, 1) is multiplied with
    /// [default: pixels of the picture that a .png would be, from its upper left]
    #[arg(long, value_name = "ROWS", value_parser = pins::projection, allow_hyphen_values = true)]
    projection: Option<Projection>,
    /// A vertex that is to stay where it is; may be given several times
    #[arg(long, value_name = "VERTEX")]
    hold: Vec<u32>,
    /// The weights now: the first row of a .csv [default: all 0]
    #[arg(long, value_name = "WEIGHTS")]
    weights: Option<PathBuf>,
    /// 100 is a full shape in WEIGHTS, and not 1
    #[arg(long, requires = "weights")]
    percent: bool,
    /// Keep weights between 0 and 1
    #[arg(long)]
    bounded: bool,
    /// What is changed as little as may be: the weights now, or the mean of the take
    #[arg(long, value_enum, default_value = "current")]
    anchor: AnchorName,
    /// Without what was learned, for comparison: no weight knows of another (the slider norm)
    #[arg(long)]
    slider: bool,
    /// The length by which a pin may miss [default: that of the training]
    #[arg(long, value_name = "LENGTH", value_parser = input::length)]
    tolerance: Option<f64>,
    /// The file to write: .obj, .glb, .png or .csv
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Pixels in a row of a picture
    #[arg(long, default_value_t = 900, value_parser = clap::value_parser!(u32).range(16..=8192))]
    width: u32,
}

/// What a solve gave.
struct Solved {
    weights: Vec<f32>,
    shaped: Shaped,
    edit: Edit,
    pins: Vec<Followed>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let path = &arguments.face;
    let inputs = [path.clone(), outline::beside(path)];
    let target = OutputFile::new(&arguments.out, &inputs)?;
    let ending = files::ending(&arguments.out, &["obj", "glb", "png", "csv"])?;
    let about = || path.display().to_string();
    let model = input::load(path)?;
    let face = input::open(&model, path)?;
    let sliders = arguments.slider.then(|| input::slider_models(&model, &face)).transpose()?;
    let solver = match &sliders {
        Some([slider, slider_mean]) => input::open(
            if matches!(arguments.anchor, AnchorName::Mean) { slider_mean } else { slider },
            path,
        )?,
        None => face,
    };
    let screen = || match arguments.projection {
        Some(projection) => Ok(projection),
        None => picture_screen(&face, &model, arguments).with_context(about),
    };
    let solved = solve(&solver, arguments, screen, output).with_context(about)?;
    let bytes = match ending {
        "csv" => {
            let weights = solved.weights.iter().copied().map(f64::from).collect();
            take::to_csv(&face.names(), &[(0, weights)])?
        }
        ending => draw(&face, &model, &solved, ending, arguments).with_context(about)?,
    };
    write(&[(&target, &bytes)])?;
    print(&face, &solved, &target, output)
}

fn solve(
    face: &BakedFace<'_>,
    arguments: &Arguments,
    screen: impl Fn() -> anyhow::Result<Projection>,
    output: Output,
) -> anyhow::Result<Solved> {
    let mut weights = vec![0.0; face.skin.shape_len()];
    if let Some(path) = &arguments.weights {
        let file = TakeFile { path, is_percent: arguments.percent };
        let take = input::take(file, &face.names(), output)?;
        let first = take.frames.first().into_iter().flatten();
        weights.iter_mut().zip(first).for_each(|(out, weight)| *out = *weight as f32);
    }
    let before = face.shaped(&weights)?;
    let len = face.skin.vertex_len();
    let mut placed = Vec::new();
    for argument in &arguments.pins {
        placed.push(argument.place(len, &screen)?);
    }
    for &vertex in &arguments.hold {
        let place = before.positions.get(vertex as usize);
        let place = place
            .with_context(|| format!("--hold {vertex}: expected a vertex from 0 to {}", len - 1))?;
        placed.push(Placed::hold(vertex, *place));
    }
    let mut options = SolveOptions::edit(&face.prior);
    options.anchor = arguments.anchor.anchor();
    options.is_bounded = arguments.bounded;
    if let Some(tolerance) = arguments.tolerance {
        options.beta = (tolerance * tolerance) as f32;
    }
    let pins: Vec<_> = placed.iter().map(|placed| placed.pin).collect();
    let edit = face.solve(&pins, &options, &mut Vec::new(), &mut weights)?;
    let shaped = face.shaped(&weights)?;
    let pins = placed.iter().map(|placed| placed.follow(&shaped)).collect::<Result<_, _>>()?;
    Ok(Solved { weights, shaped, edit, pins })
}

fn draw(
    face: &BakedFace<'_>,
    model: &Model<Vec<u8>>,
    solved: &Solved,
    ending: &str,
    arguments: &Arguments,
) -> anyhow::Result<Vec<u8>> {
    let outline = Outline::read(&arguments.face, face.skin.vertex_len())?;
    Ok(match ending {
        "obj" => outline.moved(&solved.shaped.positions).into_bytes(),
        "glb" => glb(face, outline.faces()?, &Weights::Still(&solved.weights))?,
        _ => {
            let camera = photographer(face, model, &outline, arguments)?;
            let pins: Vec<_> = solved.pins.iter().map(|pin| pin.places).collect();
            camera.take(&solved.shaped, &Paint::Clay, &pins).png()?
        }
    })
}

/// Returns the screen that the pixels of a picture are.
fn picture_screen(
    face: &BakedFace<'_>,
    model: &Model<Vec<u8>>,
    arguments: &Arguments,
) -> anyhow::Result<Projection> {
    let outline = Outline::read(&arguments.face, face.skin.vertex_len())?;
    Ok(photographer(face, model, &outline, arguments)?.projection())
}

fn photographer<'a>(
    face: &BakedFace<'_>,
    model: &Model<Vec<u8>>,
    outline: &'a Outline,
    arguments: &Arguments,
) -> anyhow::Result<Photographer<'a>> {
    let (whole, width) = (0..face.skin.vertex_len(), arguments.width as usize);
    Ok(Photographer::new(face, &model.space(), outline.faces()?, whole, width))
}

fn print(
    face: &BakedFace<'_>,
    solved: &Solved,
    target: &OutputFile,
    output: Output,
) -> anyhow::Result<()> {
    let Edit { norm, unreachable_len, is_least, .. } = solved.edit;
    let (len, free_len) = (solved.pins.len(), solved.pins.iter().filter(|pin| pin.is_free).count());
    // The runtime counts free pins too.
    let unreachable_len = unreachable_len.saturating_sub(free_len);
    let pins: Vec<_> = solved
        .pins
        .iter()
        .map(|pin| {
            let Followed { vertex, at, target, .. } = pin;
            json!({ "vertex": vertex, "at": at, "target": target, "missed": pin.missed() })
        })
        .collect();
    let names = face.names();
    let weights: serde_json::Map<_, _> =
        names.iter().cloned().zip(solved.weights.iter().map(|w| json!(w))).collect();
    let json = json!({
        "norm": norm, "unreachable": unreachable_len, "least": is_least, "pins": pins, "weights": weights,
        "file": target.named().display().to_string(),
    });
    let mut text = String::new();
    for pin in &solved.pins {
        let missed = pin.missed();
        text += &format!("vertex {:<8} misses its place by {missed:.3e}\n", pin.vertex);
    }
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|a, b| solved.weights[*b].abs().total_cmp(&solved.weights[*a].abs()));
    for shape in order.into_iter().filter(|shape| solved.weights[*shape].abs() > 0.01) {
        text += &format!("  {}{:>8.3}\n", padded(&names[shape], 24), solved.weights[shape]);
    }
    text += &format!("norm of the edit {norm:.3}\nwrote {}\n", target.named().display());
    if free_len > 0 {
        output.note("pins", format_args!("{free_len} of {len} are free in every coordinate"));
    }
    if unreachable_len > 0 {
        output.warn(
            "pins",
            format_args!("{unreachable_len} of {len} are where no shape moves anything"),
        );
    }
    output.print(&json, &text)
}
