//! `sinew views render`: one picture.

use super::input::load;
use super::values::{assignment, values};
use crate::cli::Output;
use crate::cli::files::{OutputFile, write};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::player::{Player, straight};
use std::path::PathBuf;

/// Draws the object of MODEL at parameters, as an engine does.
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
    /// The picture to write, PNG
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(&arguments.model))?;
    let model = load(&arguments.model)?;
    let mut player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let played = player.play(&values(&arguments.set)?)?;
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
        "view": view,
        "elements": drawn.element_len,
        "flipped": drawn.flipped_len,
        "points": played.points,
        "confidence": played.confidence,
    });
    output.print(&json, &text)
}
