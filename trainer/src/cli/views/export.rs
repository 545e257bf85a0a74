//! `sinew views export`: a grid of parameters, or paths, for other tools.

use super::input::{assignment, load, read_path, values};
use crate::cli::files::{OutputFile, ending, make_folder, write};
use crate::cli::{Output, counted};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::Model;
use sinew_trainer::views::export::{Grid, Side, glb, puppet, spine};
use sinew_trainer::views::set::Values;
use std::path::PathBuf;

/// Usage, one line for each format.
const USAGE: &str = "\
sinew views export [OPTIONS] --inp <GRID> --out <INP> <MODEL>
       sinew views export [OPTIONS] --spine <PATH>... --out <JSON> <MODEL>
       sinew views export [OPTIONS] --glb [<GRID>] --out <GLB> <MODEL>";

/// Writes views as an Inochi2D puppet, as Spine JSON, or as glTF
///
/// An Inochi2D puppet and binary glTF get a grid of one or two parameters of MODEL; in glTF each node is a morph
/// target. Spine gets an animation for each path.
///
/// GRID is `yaw,pitch:9x9`, or with ranges `yaw=-40..40,pitch=-20..20:9x9`. Without a range a side covers the training
/// range. All other parameters are given by --set.
#[derive(clap::Args)]
#[command(override_usage = USAGE)]
pub(in crate::cli) struct Export {
    /// A file that `sinew views train` or `transfer` wrote
    model: PathBuf,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// A parameter without a side of the grid, and not in the paths; angles in degrees; once for each
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    #[command(flatten)]
    format: Format,
    /// The file to write
    #[arg(short, long, value_name = "INP|JSON|GLB")]
    out: PathBuf,
}

/// Format to write.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Format {
    /// An Inochi2D puppet with a parameter of this grid, interpolated linearly between its nodes
    #[arg(long, value_name = "GRID", value_parser = sides)]
    inp: Option<Sides>,
    /// Binary glTF with a morph target for each node, or for each key view without a grid
    #[arg(long, value_name = "GRID", value_parser = sides, num_args = 0..=1)]
    glb: Option<Option<Sides>>,
    /// Spine JSON with an animation for each path of `animate`, named after the file of the path. Pictures go to a
    /// folder named after the output
    #[arg(long, value_name = "PATH", num_args = 1..)]
    spine: Vec<PathBuf>,
}

/// Time between frames of an animation, as in `animate`, seconds.
const FRAME_TIME: f64 = 0.04;

/// Sides of a grid.
#[derive(Clone)]
struct Sides(Vec<Side>);

fn sides(text: &str) -> Result<Sides, String> {
    let expected = || "expected a grid, as yaw,pitch:9x9 or yaw=-40..40:9".to_owned();
    let (names, counts) = text.rsplit_once(':').ok_or_else(expected)?;
    let (names, counts): (Vec<&str>, Vec<&str>) =
        (names.split(',').collect(), counts.split('x').collect());
    if names.len() != counts.len() || names.len() > 2 {
        return Err(expected());
    }
    let range = |text: &str| -> Option<[f64; 2]> {
        let (from, to) = text.split_once("..")?;
        let range = [from.parse().ok()?, to.parse().ok()?];
        range.iter().all(|x: &f64| x.is_finite()).then_some(range)
    };
    let side = |(name, count): (&str, &str)| {
        let nodes = count.parse().map_err(|_| expected())?;
        let (name, range) = match name.split_once('=') {
            None => (name, None),
            Some((name, ends)) => (name, Some(range(ends).ok_or_else(expected)?)),
        };
        Ok(Side { name: name.to_owned(), range, nodes })
    };
    names.into_iter().zip(counts).map(side).collect::<Result<_, _>>().map(Sides)
}

pub(in crate::cli) fn export(arguments: &Export, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    if !arguments.format.spine.is_empty() {
        return run_spine(arguments, output);
    }
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(&arguments.model))?;
    ending(&arguments.out, &[if arguments.format.inp.is_some() { "inp" } else { "glb" }])?;
    let model = load(&arguments.model)?;
    let (map, set) = (arguments.map.as_deref(), values(&arguments.set)?);
    let grid = |sides: &Sides| Grid::of_sides(&model, map, &set, &sides.0).with_context(about);
    let (grid, bytes) = match (&arguments.format.inp, &arguments.format.glb) {
        (Some(sides), _) => {
            let grid = grid(sides)?;
            let bytes = puppet(&model, map, &grid).with_context(about)?;
            (grid, bytes)
        }
        (None, sides) => {
            let grid = match sides.as_ref().and_then(Option::as_ref) {
                Some(sides) => grid(sides)?,
                None if !set.is_empty() => {
                    bail!("key views have parameters of their own: set none")
                }
                None => Grid::of_key_views(&model, map).with_context(about)?,
            };
            let bytes = glb(&model, map, &grid).with_context(about)?;
            if model.views().is_some_and(|views| views.has_clips()) {
                output.warn(about(), "clip masks are not written, glTF has none");
            }
            (grid, bytes)
        }
    };
    write(&[(&target, &bytes)])?;
    let mut text = format!(
        "{}: {}, {} bytes\n",
        target.named().display(),
        counted(grid.nodes.len(), "node", "nodes"),
        bytes.len()
    );
    let mut ranges = serde_json::Map::new();
    for (side, [low, high]) in &grid.sides {
        text += &format!("  {} from {low} to {high}, {} nodes\n", side.name, side.nodes);
        ranges.insert(side.name.clone(), json!([low, high]));
    }
    let nodes: Vec<_> = grid.nodes.iter().map(|node| &node.name).collect();
    output.print(&json!({ "bytes": bytes.len(), "ranges": ranges, "nodes": nodes }), &text)
}

/// Writes an animation for each path.
fn run_spine(arguments: &Export, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let paths = &arguments.format.spine;
    let taken: Vec<PathBuf> = paths.iter().chain([&arguments.model]).cloned().collect();
    ending(&arguments.out, &["json"])?;
    let target = OutputFile::new(&arguments.out, &taken)?;
    let folder = arguments.out.with_extension("");
    let set = values(&arguments.set)?;
    let model = load(&arguments.model)?;
    let mut animations = Vec::new();
    for path in paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if animations.iter().any(|(other, _)| *other == name) {
            bail!("two paths are called \"{name}\": animations have the names of their files");
        }
        let grid =
            frames(&model, arguments, &set, path).with_context(|| path.display().to_string());
        animations.push((name, grid?));
    }
    let named = folder.file_name().unwrap_or_default().to_string_lossy();
    let map = arguments.map.as_deref();
    let made = spine(&model, map, &named, &animations, FRAME_TIME).with_context(about)?;
    if !made.unclipped.is_empty() {
        let names = made.unclipped.join(", ");
        output
            .warn(about(), format!("clip masks are not written, Spine clips by polygons: {names}"));
    }
    make_folder(&folder)?;
    let mut files = Vec::new();
    for (name, bytes) in &made.pictures {
        files.push((OutputFile::new(&folder.join(format!("{name}.png")), &taken)?, bytes));
    }
    files.push((target, &made.json));
    let all: Vec<_> = files.iter().map(|(target, bytes)| (target, bytes.as_slice())).collect();
    write(&all)?;
    let text = format!(
        "{}: {}, {}, {} bytes; pictures are in {}\n",
        arguments.out.display(),
        counted(animations.len(), "animation", "animations"),
        counted(made.pictures.len(), "slot", "slots"),
        made.json.len(),
        folder.display(),
    );
    let frames = |(name, grid): &(String, Grid)| (name.clone(), json!(grid.nodes.len()));
    let frames: serde_json::Map<_, _> = animations.iter().map(frames).collect();
    let json = json!({
        "bytes": made.json.len(),
        "slots": made.pictures.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        "frames": frames,
        "unclipped": made.unclipped,
    });
    output.print(&json, &text)
}

/// Evaluates the object along a path.
fn frames(
    model: &Model<Vec<u8>>,
    arguments: &Export,
    set: &Values,
    path: &std::path::Path,
) -> anyhow::Result<Grid> {
    let mut frames = read_path(path, None)?;
    for values in &mut frames {
        for (name, value) in set {
            if values.insert(name.clone(), *value).is_some() {
                bail!("parameter \"{name}\" is set, and in the path");
            }
        }
    }
    Ok(Grid::of_frames(model, arguments.map.as_deref(), &frames)?)
}
