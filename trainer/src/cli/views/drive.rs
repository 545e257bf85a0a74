//! `sinew views drive`: pictures of tracked points.

use super::frames::{Frames, FramesArguments};
use super::input::load;
use super::track::{Follower, read};
use crate::cli::Output;
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::player::Player;
use std::path::PathBuf;

/// Bytes of a parameter that is sent.
const PARAMETER: usize = 4;

/// Draws the object as tracked points move
///
/// The parameters follow from the points, wherever they are on the screen and however large.
///
/// POINTS is CSV: a line a frame, x and y of each point, empty where a point is not seen; a first line of names is passed
/// over.
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
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let mut follower = Follower::new(&player).with_context(about)?;
    let track = read(&arguments.track, follower.point_len())?;
    let taken = [arguments.model.clone(), arguments.track.clone()];
    let mut frames = Frames::new(&arguments.frames, &taken)?;
    let mut found = Vec::new();
    for (number, points) in track.iter().enumerate() {
        let of = || format!("frame {number}");
        let own = follower.find(points).with_context(of)?;
        let played = player.play(&own.values).with_context(of)?;
        frames.add(&player.draw(&played)?.0)?;
        found.push(own);
    }
    let (written, frame_time) = frames.finish()?;
    let bytes = PARAMETER * found.first().map_or(0, |own| own.values.len());
    let off = found.iter().map(|own| own.rms).fold(0.0, f64::max);
    let text = format!(
        "{written}, {bytes} bytes of parameters each; points are off by {off:.3} px at most, RMS\n"
    );
    let all: Vec<_> =
        found.iter().map(|own| json!({ "values": own.values, "rms": own.rms })).collect();
    output.print(&json!({ "bytes": bytes, "frame_time": frame_time, "frames": all }), &text)
}
