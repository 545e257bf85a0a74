//! `sinew views render`: one picture.

use super::input::load;
use super::track::{Follower, read};
use super::values::{assignment, values};
use crate::cli::Output;
use crate::cli::files::{OutputFile, ending, write};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_trainer::views::player::{Player, straight};
use sinew_trainer::views::set::Values;
use std::path::{Path, PathBuf};

/// Draws the object at parameters, or from tracked points
///
/// It draws as an engine does.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, where MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// A parameter, angles in degrees; once for each
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// Tracked points in place of parameters, which follow from them: CSV of one frame, as `drive` takes it
    #[arg(long, value_name = "CSV", conflicts_with = "set")]
    points: Option<PathBuf>,
    /// The picture to write, PNG
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let taken: Vec<PathBuf> = [Some(&arguments.model), arguments.points.as_ref()]
        .into_iter()
        .flatten()
        .cloned()
        .collect();
    let target = OutputFile::new(&arguments.out, &taken)?;
    ending(&arguments.out, &["png"])?;
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let values = match &arguments.points {
        Some(file) => tracked(&mut Follower::new(&player), file)?,
        None => values(&arguments.set)?,
    };
    let played = player.play(&values)?;
    let (picture, drawn) = player.draw(&played)?;
    write(&[(&target, &straight(&picture).png()?)])?;
    let view = player.views().view_name(played.view).unwrap_or_default();
    let text = format!(
        "{}: view {view}, {} elements, {} of them turned over\n",
        target.named().display(),
        drawn.element_len,
        drawn.flipped_len
    );
    let json = json!({
        "values": values,
        "view": view,
        "key_views": player.key_names(),
        "weights": played.weights(),
        "elements": drawn.element_len,
        "flipped": drawn.flipped_len,
        "points": played.points,
        "confidence": played.confidence,
    });
    output.print(&json, &text)
}

/// Finds the parameters of the one frame of a file.
fn tracked(follower: &mut Follower, file: &Path) -> anyhow::Result<Values> {
    let about = || file.display().to_string();
    match &read(file, follower.point_len())?[..] {
        [points] => Ok(follower.find(points).with_context(about)?.values),
        frames => bail!("{}: expected one frame, found {}", about(), frames.len()),
    }
}
