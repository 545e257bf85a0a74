//! `sinew views animate`: pictures along a path of parameters.

use super::frames::{Frames, FramesArguments};
use super::input::load;
use crate::cli::Output;
use anyhow::{Context, bail};
use serde::Deserialize;
use serde_json::json;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::Values;
use std::path::{Path, PathBuf};

/// Draws the object along a path of parameters
///
/// PATH is JSON: `keys`, a list of parameters by name, and `frames`, how many pictures lead from each key to the next.
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
    #[command(flatten)]
    frames: FramesArguments,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    keys: Vec<Values>,
    #[serde(default = "frames")]
    frames: usize,
}

const fn frames() -> usize {
    12
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let path = read(&arguments.path)?;
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

/// Lists the parameters of all frames.
fn read(file: &Path) -> anyhow::Result<Vec<Values>> {
    let about = || file.display().to_string();
    let text = std::fs::read(file).with_context(about)?;
    let Written { keys, frames } = serde_json::from_slice(&text).with_context(about)?;
    let (Some(last), true) = (keys.last(), frames > 0) else {
        bail!("{}: expected `keys`, and `frames` above 0", about());
    };
    let mut out = Vec::new();
    for pair in keys.windows(2) {
        for frame in 0..frames {
            let share = frame as f64 / frames as f64;
            let between = |(name, from): (&String, &f64)| {
                let to = pair[1].get(name).unwrap_or(from);
                (name.clone(), from + share * (to - from))
            };
            out.push(pair[0].iter().map(between).collect());
        }
    }
    out.push(last.clone());
    Ok(out)
}
