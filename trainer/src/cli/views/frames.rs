//! `sinew views animate` and `drive`: many pictures, numbered in a folder or in one GIF.

use super::input::{Follower, MapArgs, read_path, read_track};
use crate::cli::files::write;
use crate::cli::{OfFile, Output, OutputFile, Report, Run, count, counted, ending, number};
use crate::files;
use crate::page::picture::{Gif, Picture};
use crate::views::player::straight;
use crate::views::set::Values;
use anyhow::{Context, bail};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

/// Draws the object along a path of parameters
///
/// PATH is JSON: `keys`, a list of parameters by name, and `frames`, the number of pictures, by default 24. The first
/// picture shows the first key, the last picture shows the last key, and the others are evenly spread.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views animate head.sinew --path turn.json -o turn.gif")]
pub(in crate::cli) struct Animate {
    #[command(flatten)]
    views: MapArgs,
    /// The path
    #[arg(long, value_name = "PATH")]
    path: PathBuf,
    /// Number of pictures, in place of `frames` of PATH
    #[arg(long = "frames", value_name = "N", value_parser = count(1, 1_000_000))]
    count: Option<usize>,
    #[command(flatten)]
    frames: FramesArguments,
}

impl Run for Animate {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let path = read_path(&self.path, self.count)?;
        let model = self.views.model.load()?;
        let player = self.views.player(&model)?;
        let taken = [self.views.model.file.clone(), self.path.clone()];
        let mut frames = Frames::new(&self.frames, &taken)?;
        for (number, values) in path.iter().enumerate() {
            let played = player.play(values).with_context(|| format!("frame {number}"))?;
            frames.add(&player.draw(&played)?.0)?;
        }
        let count = frames.count;
        Ok(frames.finish()?.json("frames", count))
    }
}

/// Bytes of a transmitted parameter.
const PARAMETER: usize = 4;

/// Draws the object as tracked points move
///
/// The parameters follow from the points. The position and size of the points on the screen do not matter.
///
/// POINTS is CSV: a line for each frame with x and y of each point, empty if a point is hidden. A first line of names
/// is skipped. For an object that `sinew views transfer` made, the points are the object's own, not those of its
/// prototype.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views drive head.sinew --track points.csv -o driven.gif")]
pub(in crate::cli) struct Drive {
    #[command(flatten)]
    views: MapArgs,
    /// Tracked points
    #[arg(long, value_name = "POINTS")]
    track: PathBuf,
    /// Write a table too, with a line for each frame: number, parameters, RMS distance of the points, and weight of
    /// each key view
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    frames: FramesArguments,
}

/// A driven frame.
#[derive(Serialize)]
struct Driven {
    values: Values,
    rms: f64,
    /// Weights of the key views.
    weights: Vec<f64>,
}

impl Run for Drive {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let model = self.views.model.load()?;
        let player = self.views.player(&model)?;
        let mut follower = Follower::new(&player);
        let track = read_track(&self.track, follower.point_len())?;
        let taken = [self.views.model.file.clone(), self.track.clone()];
        let file =
            self.csv.as_deref().map(|path| OutputFile::new(path, &taken)?.ending_in(&["csv"]));
        let table = file.transpose()?;
        let mut frames = Frames::new(&self.frames, &taken)?;
        let mut driven = Vec::new();
        for (number, points) in track.iter().enumerate() {
            let of = || format!("frame {number}");
            let found = follower.find(points).with_context(of)?;
            let played = player.play(&found.values).with_context(of)?;
            frames.add(&player.draw(&played)?.0)?;
            driven.push(Driven { weights: played.weights(), values: found.values, rms: found.rms });
        }
        let report = frames.finish()?;
        let bytes = PARAMETER * driven.first().map_or(0, |own| own.values.len());
        let largest = driven.iter().map(|own| own.rms).fold(0.0, f64::max);
        let names = player.key_names();
        let report = report
            .figure("bytes", "parameters of a frame", bytes, "bytes")
            .figure("largest_rms", "error of the points, RMS, at most", largest, "px")
            .json("key_views", &names)
            .json("frames", &driven);
        let Some(target) = &table else { return Ok(report) };
        write(&[(target, &as_table(&driven, &names)?)])?;
        let lines = counted(driven.len(), "line", "lines");
        Ok(report.text(format!("wrote {} ({lines})", target.named.display())))
    }
}

/// Writes a line of names, then a line for each frame.
fn as_table(driven: &[Driven], key_views: &[&str]) -> anyhow::Result<Vec<u8>> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let parameters = driven.iter().take(1).flat_map(|own| own.values.keys().cloned());
    // A key view may have the name of a parameter.
    let views = key_views.iter().map(|name| format!("view {name}"));
    let names = std::iter::once("frame".to_owned()).chain(parameters);
    out.write_record(names.chain(["rms".to_owned()]).chain(views))?;
    for (number, own) in driven.iter().enumerate() {
        let numbers = own.values.values().chain([&own.rms]).chain(&own.weights);
        let cells = numbers.map(f64::to_string);
        out.write_record(std::iter::once(number.to_string()).chain(cells))?;
    }
    Ok(out.into_inner()?)
}

/// Destination of pictures.
#[derive(clap::Args)]
struct FramesArguments {
    /// Folder for the pictures, PNG; or one GIF on white, if the name ends in .gif
    #[arg(short, long, alias = "out", value_name = "FOLDER|GIF")]
    output: PathBuf,
    /// Time of each picture in a GIF: whole hundredths of a second, at least 0.02
    #[arg(long, value_name = "SECONDS", default_value = "0.04", value_parser = number(0.02..=655.35, " seconds"))]
    frame_time: f64,
}

/// Writer of numbered pictures or of a GIF.
struct Frames {
    /// Folder or GIF.
    named: PathBuf,
    gif: Option<(OutputFile, Gif)>,
    /// Time of each picture, in hundredths of a second, the unit of GIF.
    hundredths: u16,
    count: usize,
}

impl Frames {
    /// Begins a GIF, or makes the folder. A folder must hold no pictures of an earlier run.
    ///
    /// - `taken`: input files, which must not be overwritten.
    fn new(arguments: &FramesArguments, taken: &[PathBuf]) -> anyhow::Result<Self> {
        let named = arguments.output.clone();
        let hundredths = (100.0 * arguments.frame_time).round() as u16;
        let gif = if ending(&named, &["gif"]).is_ok() {
            Some((OutputFile::new(&named, taken)?, Gif::new(hundredths)))
        } else {
            std::fs::create_dir_all(&named).of(&named)?;
            if named.join(name(0)).exists() {
                bail!("{}: it holds frames already", named.display());
            }
            None
        };
        Ok(Self { named, gif, hundredths, count: 0 })
    }

    /// Adds the next picture, with premultiplied colours.
    fn add(&mut self, picture: &Picture) -> anyhow::Result<()> {
        let picture = straight(picture);
        if let Some((_, gif)) = &mut self.gif {
            gif.add(&picture).of(&self.named)?;
        } else {
            let path = self.named.join(name(self.count));
            files::write(&path, &picture.png()?)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        self.count += 1;
        Ok(())
    }

    /// Writes the GIF, and reports the pictures. The time of each picture is null for a folder.
    fn finish(self) -> anyhow::Result<Report> {
        let count = counted(self.count, "frame", "frames");
        let named = self.named.display();
        let Some((target, gif)) = self.gif else {
            let report = Report::default().text(format!("{named}: {count}"));
            return Ok(report.json("frame_time", json!(null)));
        };
        write(&[(&target, &gif.finish()?)])?;
        let seconds = f64::from(self.hundredths) / 100.0;
        let text = format!("{named}: {count} of {seconds:.2} s");
        Ok(Report::default().shown("frame_time", "", seconds, text))
    }
}

fn name(number: usize) -> String {
    format!("frame{number:04}.png")
}
