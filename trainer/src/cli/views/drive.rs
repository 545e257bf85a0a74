//! `sinew views drive`: pictures of tracked points.

use super::frames::{Frames, FramesArguments};
use super::input::load;
use super::track::{Follower, read};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted};
use anyhow::Context;
use serde::Serialize;
use serde_json::json;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::Values;
use std::path::{Path, PathBuf};

/// Bytes of a parameter that is sent.
const PARAMETER: usize = 4;

/// Draws the object as tracked points move
///
/// The parameters follow from the points, wherever they are on the screen and however large.
///
/// POINTS is CSV: a line a frame, x and y of each point, empty where a point is not seen; a first line of names is passed
/// over. Points of an object that `sinew views transfer` made are its own, not those of its prototype.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, where MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// Tracked points
    #[arg(long, value_name = "POINTS")]
    track: PathBuf,
    #[command(flatten)]
    frames: FramesArguments,
    /// Also writes a table with a line a frame: number, parameters, RMS distance of the points, weight of each key view
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
}

/// A driven frame.
#[derive(Serialize)]
struct Driven {
    values: Values,
    rms: f64,
    /// By key view.
    weights: Vec<f64>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let mut follower = Follower::new(&player);
    let track = read(&arguments.track, follower.point_len())?;
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

/// Writes a line a frame, and a line of names above.
fn as_table(driven: &[Driven], key_views: &[&str]) -> anyhow::Result<Vec<u8>> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let parameters = driven.iter().take(1).flat_map(|own| own.values.keys().cloned());
    // A key view may be named as a parameter is.
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
