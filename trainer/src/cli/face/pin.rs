//! `sinew face pin`: a few points dragged, and the face that follows.

use super::input::{self, AnchorName};
use crate::cli::files::{OutputFile, write};
use crate::cli::{Output, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::prior::{Edit, Pin};
use sinew_trainer::face::baked::{BakedFace, Shaped, Terms};
use sinew_trainer::face::outline::{self, Outline};
use sinew_trainer::face::picture::{Paint, Photographer};
use sinew_trainer::face::scene::{Weights, glb};
use sinew_trainer::face::take;
use std::path::{Path, PathBuf};

/// Drags vertices of FACE to places and lets the rest of the face follow as it did in the take.
///
/// Writes the mesh (.obj), the mesh with its shapes and weights (.glb), a picture (.png), or the weights (.csv).
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew face train` wrote
    face: PathBuf,
    /// A vertex and where it is to be, _ for a coordinate that is free; may be given several times
    #[arg(long = "pin", value_name = "VERTEX=X,Y,Z", value_parser = pin, allow_hyphen_values = true)]
    pins: Vec<PinArgument>,
    /// A vertex that is to stay where it is; may be given several times
    #[arg(long, value_name = "VERTEX")]
    hold: Vec<u32>,
    /// The weights now: the first row of a .csv [default: all 0]
    #[arg(long, value_name = "WEIGHTS")]
    weights: Option<PathBuf>,
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

/// A vertex, and the coordinates that are pinned.
#[derive(Clone, Copy, Debug)]
struct PinArgument {
    vertex: u32,
    at: [Option<f32>; 3],
}

/// What a solve gave.
struct Solved {
    weights: Vec<f32>,
    shaped: Shaped,
    edit: Edit,
    /// Vertex, where it is, and where it was to be.
    pins: Vec<(usize, [f64; 3], [f64; 3])>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let path = &arguments.face;
    let inputs = [path.clone(), outline::beside(path)];
    let target = OutputFile::new(&arguments.out, &inputs)?;
    let ending = ending(&arguments.out)?;
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
    let solved = solve(&solver, arguments, output).with_context(about)?;
    let bytes = match ending {
        Ending::Csv => {
            let weights = solved.weights.iter().copied().map(f64::from).collect();
            take::to_csv(&face.names(), &[(0, weights)])?
        }
        ending => draw(&face, &model, &solved, ending, arguments).with_context(about)?,
    };
    write(&[(&target, &bytes)])?;
    print(&face, &solved, &target, output)
}

fn solve(face: &BakedFace<'_>, arguments: &Arguments, output: Output) -> anyhow::Result<Solved> {
    let mut weights = vec![0.0; face.skin.shape_len()];
    if let Some(path) = &arguments.weights {
        let take = input::take(path, &face.names(), output)?;
        let first = take.frames.first().into_iter().flatten();
        weights.iter_mut().zip(first).for_each(|(out, weight)| *out = *weight as f32);
    }
    let before = face.shaped(&weights)?;
    let len = face.skin.vertex_len();
    let mut pins = Vec::new();
    for argument in &arguments.pins {
        let vertex = argument.vertex;
        if vertex as usize >= len {
            bail!("--pin {vertex}: expected a vertex from 0 to {}", len - 1);
        }
        let target = argument.at.map(|x| x.unwrap_or_default());
        pins.push(Pin::new(vertex, target).masked(argument.at.map(|x| x.is_some())));
    }
    for &vertex in &arguments.hold {
        let place = before.positions.get(vertex as usize);
        let place = place
            .with_context(|| format!("--hold {vertex}: expected a vertex from 0 to {}", len - 1))?;
        pins.push(Pin::new(vertex, place.map(|x| x as f32)));
    }
    let mut terms = Terms::edit(&face.prior);
    terms.anchor = arguments.anchor.anchor();
    terms.is_bounded = arguments.bounded;
    if let Some(tolerance) = arguments.tolerance {
        terms.beta = (tolerance * tolerance) as f32;
    }
    let edit = face.solve(&pins, &terms, &mut Vec::new(), &mut weights)?;
    let shaped = face.shaped(&weights)?;
    let pins = pins.iter().map(|pin| {
        let vertex = pin.vertex as usize;
        let place = shaped.positions[vertex];
        // A coordinate that is free is where it is.
        let target = [0, 1, 2].map(|axis| match pin.rows[axis] == [0.0; 4] {
            true => place[axis],
            false => f64::from(pin.target[axis]),
        });
        (vertex, place, target)
    });
    let pins = pins.collect();
    Ok(Solved { weights, shaped, edit, pins })
}

fn draw(
    face: &BakedFace<'_>,
    model: &Model<Vec<u8>>,
    solved: &Solved,
    ending: Ending,
    arguments: &Arguments,
) -> anyhow::Result<Vec<u8>> {
    let outline = Outline::read(&arguments.face, face.skin.vertex_len())?;
    Ok(match ending {
        Ending::Obj => outline.moved(&solved.shaped.positions).into_bytes(),
        Ending::Glb => glb(face, outline.faces()?, &Weights::Still(&solved.weights))?,
        _ => {
            let whole = 0..face.skin.vertex_len();
            let width = arguments.width as usize;
            let camera = Photographer::new(face, &model.space(), outline.faces()?, whole, width);
            let pins: Vec<_> = solved.pins.iter().map(|(_, from, to)| (*from, *to)).collect();
            camera.take(&solved.shaped, &Paint::Clay, &pins).png()?
        }
    })
}

fn print(
    face: &BakedFace<'_>,
    solved: &Solved,
    target: &OutputFile,
    output: Output,
) -> anyhow::Result<()> {
    let missed = |(_, a, b): &(usize, [f64; 3], [f64; 3])| {
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let Edit { norm, unreachable_len, is_least, .. } = solved.edit;
    let pins: Vec<_> = solved
        .pins
        .iter()
        .map(|pin| json!({ "vertex": pin.0, "at": pin.1, "target": pin.2, "missed": missed(pin) }))
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
        text += &format!("vertex {:<8} misses its place by {:.3e}\n", pin.0, missed(pin));
    }
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|a, b| solved.weights[*b].abs().total_cmp(&solved.weights[*a].abs()));
    for shape in order.into_iter().filter(|shape| solved.weights[*shape].abs() > 0.01) {
        text += &format!("  {:<24}{:>8.3}\n", printable(&names[shape]), solved.weights[shape]);
    }
    text += &format!("norm of the edit {norm:.3}\nwrote {}\n", target.named().display());
    if unreachable_len > 0 {
        output.warn(
            "pins",
            format_args!(
                "{unreachable_len} of {} are where no shape moves anything",
                solved.pins.len()
            ),
        );
    }
    output.print(&json, &text)
}

/// What to write.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ending {
    Obj,
    Glb,
    Png,
    Csv,
}

fn ending(path: &Path) -> anyhow::Result<Ending> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("obj") => Ok(Ending::Obj),
        Some("glb") => Ok(Ending::Glb),
        Some("png") => Ok(Ending::Png),
        Some("csv") => Ok(Ending::Csv),
        _ => bail!("{}: expected a file that ends in .obj, .glb, .png or .csv", path.display()),
    }
}

/// Parses a vertex and its place.
fn pin(text: &str) -> Result<PinArgument, String> {
    let expected = || "expected VERTEX=X,Y,Z, _ for a coordinate that is free".to_owned();
    let (vertex, place) = text.split_once('=').ok_or_else(expected)?;
    let vertex = vertex.trim().parse().map_err(|_| expected())?;
    let number = |word: &str| match word.trim() {
        "_" => Ok(None),
        word => match word.parse::<f32>() {
            Ok(x) if x.is_finite() => Ok(Some(x)),
            _ => Err(expected()),
        },
    };
    let numbers = place.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    let at = numbers.try_into().map_err(|_| expected())?;
    Ok(PinArgument { vertex, at })
}
