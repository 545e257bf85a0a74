//! `sinew views animate`: pictures along a path of parameters.

use super::frames::{Frames, FramesArguments};
use super::input::load;
use super::path::read;
use crate::cli::Output;
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::player::Player;
use std::path::PathBuf;

/// Draws the object along a path of parameters
///
/// PATH is JSON: `keys`, a list of parameters by name, and `frames`, the number of pictures. The first one shows the first
/// key, the last one the last key, and the others are evenly spread. There are 24 if PATH names no number.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, where MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// The path
    #[arg(long, value_name = "PATH")]
    path: PathBuf,
    /// How many pictures to write, in place of `frames` of PATH
    #[arg(long = "frames", value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    count: Option<u32>,
    #[command(flatten)]
    frames: FramesArguments,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let path = read(&arguments.path, arguments.count.map(|count| count as usize))?;
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
