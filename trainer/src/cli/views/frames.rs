//! `sinew views animate` and `drive`: many pictures, numbered in a folder or in one GIF.

use super::input::{load, read_path};
use super::track::{Follower, read_track};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted};
use anyhow::{Context, bail};
use serde::Serialize;
use serde_json::json;
use sinew_trainer::files;
use sinew_trainer::page::picture::Gif;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::player::{Player, straight};
use sinew_trainer::views::set::Values;
use std::path::{Path, PathBuf};

/// Draws the object along a path of parameters
///
/// PATH is JSON: `keys`, a list of parameters by name, and `frames`, the number of pictures, by default 24. The first
/// picture shows the first key, the last picture shows the last key, and the others are evenly spread.
#[derive(clap::Args)]
pub(in crate::cli) struct Animate {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// The path
    #[arg(long, value_name = "PATH")]
    path: PathBuf,
    /// Number of pictures, in place of `frames` of PATH
    #[arg(long = "frames", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    count: Option<u32>,
    #[command(flatten)]
    frames: FramesArguments,
}

pub(in crate::cli) fn animate(arguments: &Animate, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let path = read_path(&arguments.path, arguments.count.map(|count| count as usize))?;
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let mut frames =
        Frames::new(&arguments.frames, &[arguments.model.clone(), arguments.path.clone()])?;
    for (number, values) in path.iter().enumerate() {
        let played = player.play(values).with_context(|| format!("frame {number}"))?;
        frames.add(&player.draw(&played)?.0)?;
    }
    let count = frames.count();
    let (text, frame_time) = frames.finish()?;
    output.print(&json!({ "frames": count, "frame_time": frame_time }), &text)
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
pub(in crate::cli) struct Drive {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// Tracked points
    #[arg(long, value_name = "POINTS")]
    track: PathBuf,
    #[command(flatten)]
    frames: FramesArguments,
    /// Also writes a table with a line for each frame: number, parameters, RMS distance of the points, and weight of
    /// each key view
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
}

/// A driven frame.
#[derive(Serialize)]
struct Driven {
    values: Values,
    rms: f64,
    /// Weights of the key views.
    weights: Vec<f64>,
}

pub(in crate::cli) fn drive(arguments: &Drive, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let mut follower = Follower::new(&player);
    let track = read_track(&arguments.track, follower.point_len())?;
    let taken = [arguments.model.clone(), arguments.track.clone()];
    let table = arguments.csv.as_deref().map(|path| table_file(path, &taken)).transpose()?;
    let mut frames = Frames::new(&arguments.frames, &taken)?;
    let mut driven = Vec::new();
    for (number, points) in track.iter().enumerate() {
        let of = || format!("frame {number}");
        let found = follower.find(points).with_context(of)?;
        let played = player.play(&found.values).with_context(of)?;
        frames.add(&player.draw(&played)?.0)?;
        driven.push(Driven { weights: played.weights(), values: found.values, rms: found.rms });
    }
    let (written, frame_time) = frames.finish()?;
    let bytes = PARAMETER * driven.first().map_or(0, |own| own.values.len());
    let off = driven.iter().map(|own| own.rms).fold(0.0, f64::max);
    let mut text = format!(
        "{written}, {bytes} bytes of parameters each; points are off by {off:.3} px at most, RMS\n"
    );
    let names = player.key_names();
    if let Some(target) = &table {
        write(&[(target, &as_table(&driven, &names)?)])?;
        text +=
            &format!("{}: {}\n", target.named().display(), counted(driven.len(), "line", "lines"));
    }
    let json = json!({
        "bytes": bytes,
        "frame_time": frame_time,
        "key_views": names,
        "frames": driven,
    });
    output.print(&json, &text)
}

fn table_file(path: &Path, taken: &[PathBuf]) -> anyhow::Result<OutputFile> {
    ending(path, &["csv"])?;
    OutputFile::new(path, taken)
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
pub(super) struct FramesArguments {
    /// The folder for the pictures, PNG; or one GIF on white, if the name ends in .gif
    #[arg(short, long, value_name = "FOLDER|GIF")]
    out: PathBuf,
    /// Time of each picture in a GIF, in seconds: whole hundredths, at least 0.02
    #[arg(long, value_name = "SECONDS", default_value = "0.04", value_parser = hundredths)]
    frame_time: u16,
}

/// Writer of numbered pictures or of a GIF.
pub(super) struct Frames {
    place: Place,
    named: PathBuf,
    count: usize,
}

enum Place {
    Folder,
    Gif { target: OutputFile, pictures: Gif, hundredths: u16 },
}

/// Unit of time in GIF, seconds.
const HUNDREDTH: f64 = 0.01;

fn hundredths(text: &str) -> Result<u16, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    let hundredths = (seconds / HUNDREDTH).round();
    // Browsers replace times below two hundredths by ten hundredths.
    if (2.0..=f64::from(u16::MAX)).contains(&hundredths) {
        Ok(hundredths as u16)
    } else {
        Err("expected 0.02 seconds or more, 655.35 at most".to_owned())
    }
}

impl Frames {
    /// Begins a GIF, or makes the folder. A folder must hold no pictures of an earlier run.
    ///
    /// - `taken`: input files, which must not be overwritten.
    pub(super) fn new(arguments: &FramesArguments, taken: &[PathBuf]) -> anyhow::Result<Self> {
        let FramesArguments { out, frame_time } = arguments;
        let is_gif = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif"));
        let place = if is_gif {
            let target = OutputFile::new(out, taken)?;
            Place::Gif { target, pictures: Gif::new(*frame_time), hundredths: *frame_time }
        } else {
            folder(out)?;
            Place::Folder
        };
        Ok(Self { place, named: out.clone(), count: 0 })
    }

    /// Adds the next picture, with premultiplied colours.
    pub(super) fn add(&mut self, picture: &Picture) -> anyhow::Result<()> {
        let picture = straight(picture);
        match &mut self.place {
            Place::Folder => {
                let path = self.named.join(name(self.count));
                files::write(&path, &picture.png()?)
                    .with_context(|| format!("cannot write {}", path.display()))?;
            }
            Place::Gif { pictures, .. } => {
                pictures.add(&picture).with_context(|| self.named.display().to_string())?;
            }
        }
        self.count += 1;
        Ok(())
    }

    /// Writes all that remains.
    ///
    /// Returns a summary as text, and the time of each picture as JSON (null for a folder).
    pub(super) fn finish(self) -> anyhow::Result<(String, serde_json::Value)> {
        let count = counted(self.count, "frame", "frames");
        let named = self.named.display();
        let Place::Gif { target, pictures, hundredths } = self.place else {
            return Ok((format!("{named}: {count}"), serde_json::Value::Null));
        };
        write(&[(&target, &pictures.finish()?)])?;
        let seconds = f64::from(hundredths) * HUNDREDTH;
        Ok((format!("{named}: {count} of {seconds:.2} s"), seconds.into()))
    }

    /// Returns the number of pictures.
    pub(super) fn count(&self) -> usize {
        self.count
    }
}

fn folder(folder: &Path) -> anyhow::Result<()> {
    let about = || folder.display().to_string();
    std::fs::create_dir_all(folder).with_context(about)?;
    if folder.join(name(0)).exists() {
        bail!("{}: it holds frames already", about());
    }
    Ok(())
}

fn name(number: usize) -> String {
    format!("frame{number:04}.png")
}
