//! `sinew views export`: a grid of parameters, or paths, for other tools.

use super::input::{MapArgs, assignment, read_path, values};
use crate::cli::files::{make_folder, write};
use crate::cli::{OfFile, Output, OutputFile, Report, Run};
use crate::views::export::{Grid, Side, glb, puppet, spine};
use crate::views::set::Values;
use anyhow::bail;
use serde_json::{Value, json};
use sinew_runtime::{Model, Views};
use std::path::{Path, PathBuf};

/// Usage, one line for each format.
const USAGE: &str = "\
sinew views export [OPTIONS] --inp <GRID> --output <INP> <MODEL>
       sinew views export [OPTIONS] --spine <PATH>... --output <JSON> <MODEL>
       sinew views export [OPTIONS] --glb [<GRID>] --output <GLB> <MODEL>";

/// Writes views as an Inochi2D puppet, as Spine JSON, or as glTF
///
/// An Inochi2D puppet and binary glTF get a grid of one or two parameters of MODEL; in glTF each node is a morph
/// target. Spine gets an animation for each path.
///
/// GRID is `yaw,pitch:9x9`, or with ranges `yaw=-40..40,pitch=-20..20:9x9`. Without a range a side covers the training
/// range. All other parameters are given by --set.
#[derive(clap::Args)]
#[command(override_usage = USAGE)]
#[command(after_help = "Example:\n  sinew views export head.sinew --glb yaw=-60..60:7 -o head.glb")]
pub(in crate::cli) struct Export {
    #[command(flatten)]
    views: MapArgs,
    /// A parameter without a side of the grid, and not in the paths; angles in degrees; repeatable
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "INP|JSON|GLB")]
    output: PathBuf,
    #[command(flatten)]
    format: Format,
}

/// Format to write.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
#[command(next_help_heading = "Format")]
struct Format {
    /// Inochi2D puppet with a parameter of this grid, interpolated linearly between its nodes
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

impl Run for Export {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        if !self.format.spine.is_empty() {
            return self.spine(output);
        }
        let file = &self.views.model.file;
        let known = if self.format.inp.is_some() { "inp" } else { "glb" };
        let target = OutputFile::new(&self.output, [file])?.ending_in(&[known])?;
        let model = self.views.model.load()?;
        let (map, set) = (self.views.map.as_deref(), values(&self.set)?);
        let sides = self.format.inp.as_ref().or(self.format.glb.iter().flatten().next());
        let grid = match sides {
            Some(Sides(sides)) => Grid::of_sides(&model, map, &set, sides).of(file)?,
            None if !set.is_empty() => bail!("key views have parameters of their own: set none"),
            None => Grid::of_key_views(&model, map).of(file)?,
        };
        let bytes = match self.format.inp {
            Some(_) => puppet(&model, map, &grid).of(file)?,
            None => glb(&model, map, &grid).of(file)?,
        };
        if self.format.inp.is_none()
            && model.first::<Views>().is_some_and(|views| views.has_clips())
        {
            output.warn(file.display(), "clip masks are not written, glTF has none");
        }
        let ranges = grid.sides.iter().map(|(side, range)| (side.name.clone(), json!(range)));
        let ranges = Value::Object(ranges.collect());
        let nodes: Vec<_> = grid.nodes.iter().map(|node| &node.name).collect();
        let report = Report::default().shown("nodes", "nodes", &nodes, nodes.len().to_string());
        let report = grid.sides.iter().fold(report, |report, (side, [low, high])| {
            report.text(format!("{} from {low} to {high}, {} nodes", side.name, side.nodes))
        });
        report.json("ranges", ranges).write(&target, &bytes)
    }
}

impl Export {
    /// Writes an animation for each path.
    fn spine(&self, output: Output) -> anyhow::Result<Report> {
        let paths = &self.format.spine;
        let taken: Vec<PathBuf> = paths.iter().chain([&self.views.model.file]).cloned().collect();
        let target = OutputFile::new(&self.output, &taken)?.ending_in(&["json"])?;
        let folder = self.output.with_extension("");
        let set = values(&self.set)?;
        let model = self.views.model.load()?;
        let mut animations = Vec::new();
        for path in paths {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if animations.iter().any(|(other, _)| *other == name) {
                bail!("two paths are called \"{name}\": animations have the names of their files");
            }
            let grid = self.frames(&model, &set, path).of(path);
            animations.push((name, grid?));
        }
        let named = folder.file_name().unwrap_or_default().to_string_lossy();
        let map = self.views.map.as_deref();
        let made =
            spine(&model, map, &named, &animations, FRAME_TIME).of(&self.views.model.file)?;
        if !made.unclipped.is_empty() {
            let names = made.unclipped.join(", ");
            let text = format!("clip masks are not written, Spine clips by polygons: {names}");
            output.warn(self.views.model.file.display(), text);
        }
        make_folder(&folder)?;
        let mut files = Vec::new();
        for (name, bytes) in &made.pictures {
            files.push((OutputFile::new(&folder.join(format!("{name}.png")), &taken)?, bytes));
        }
        files.push((target, &made.json));
        let all: Vec<_> = files.iter().map(|(target, bytes)| (target, bytes.as_slice())).collect();
        write(&all)?;
        let frames = |(name, grid): &(String, Grid)| (name.clone(), json!(grid.nodes.len()));
        let frames = Value::Object(animations.iter().map(frames).collect());
        let slots: Vec<_> = made.pictures.iter().map(|(name, _)| name).collect();
        Ok(Report::default()
            .figure("frames", "frames of the animations", frames, "")
            .shown("slots", "slots", &slots, slots.len().to_string())
            .json("unclipped", &made.unclipped)
            .wrote(&files[files.len() - 1].0, &made.json)
            .text(format!("pictures are in {}", folder.display())))
    }

    /// Evaluates the object along a path.
    fn frames(&self, model: &Model<Vec<u8>>, set: &Values, path: &Path) -> anyhow::Result<Grid> {
        let mut frames = read_path(path, None)?;
        for values in &mut frames {
            for (name, value) in set {
                if values.insert(name.clone(), *value).is_some() {
                    bail!("parameter \"{name}\" is set, and in the path");
                }
            }
        }
        Ok(Grid::of_frames(model, self.views.map.as_deref(), &frames)?)
    }
}
