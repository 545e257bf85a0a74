//! `sinew views export`: a grid of parameters for tools that go by grids.

use super::input::load;
use super::values::{assignment, values};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_trainer::views::export::{Grid, Side, glb, puppet};
use std::path::PathBuf;

/// Writes a grid of views as an Inochi2D puppet or as glTF
///
/// The grid has one or two parameters of MODEL. Binary glTF has them as morph targets.
///
/// GRID is `yaw,pitch:9x9`, or, from where to where, `yaw=-40..40,pitch=-20..20:9x9`. Without a range a number goes as far
/// as the examples do, and an angle as far as they turn. All other parameters are set.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` or `transfer` wrote
    model: PathBuf,
    /// Name of the map, where MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// A parameter that has no side of the grid, angles in degrees; once for each
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    #[command(flatten)]
    format: Format,
    /// The file to write
    #[arg(short, long, value_name = "INP|GLB")]
    out: PathBuf,
}

/// What to write.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Format {
    /// An Inochi2D puppet with a parameter of this grid, which is bent along lines between its nodes
    #[arg(long, value_name = "GRID", value_parser = sides)]
    inp: Option<Sides>,
    /// Binary glTF with a morph target a node, or, without a grid, a key view
    #[arg(long, value_name = "GRID", value_parser = sides, num_args = 0..=1)]
    glb: Option<Option<Sides>>,
}

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

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
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
