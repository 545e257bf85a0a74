//! `sinew views render` and `pin`: one picture.

use super::input::{assignment, load, values};
use super::track::{Follower, read_track};
use crate::cli::Output;
use crate::cli::files::{OutputFile, ending, write};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_trainer::views::object::FileMap;
use sinew_trainer::views::pin::{Pin, bend, follow};
use sinew_trainer::views::player::{Player, straight};
use sinew_trainer::views::set::Values;
use std::path::{Path, PathBuf};

/// Draws the object at parameters, or from tracked points
///
/// The runtime draws, as in an engine.
#[derive(clap::Args)]
pub(in crate::cli) struct Render {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// A parameter; angles in degrees; once for each
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// Tracked points in place of parameters: CSV of one frame, as for `drive`. The parameters follow from the points
    #[arg(long, value_name = "CSV", conflicts_with = "set")]
    points: Option<PathBuf>,
    /// The picture to write, PNG
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
}

pub(in crate::cli) fn render(arguments: &Render, output: Output) -> anyhow::Result<()> {
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

/// Finds the parameters of the only frame of a file.
fn tracked(follower: &mut Follower, file: &Path) -> anyhow::Result<Values> {
    let about = || file.display().to_string();
    match &read_track(file, follower.point_len())?[..] {
        [points] => Ok(follower.find(points).with_context(about)?.values),
        frames => bail!("{}: expected one frame, found {}", about(), frames.len()),
    }
}

/// Draws the object with points dragged to places
///
/// The parameters follow first, by their covariance in training. Then the neighbourhood of each point follows.
#[derive(clap::Args)]
pub(in crate::cli) struct PinPoints {
    /// A file that `sinew views train` wrote
    model: PathBuf,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    map: Option<String>,
    /// A parameter to start from; angles in degrees; once for each
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// The number of a point and the position to drag it to, in pixels; once for each
    #[arg(long, value_name = "POINT=X,Y", value_parser = dragged, required = true)]
    pin: Vec<Pin>,
    /// The picture to write, PNG
    #[arg(short, long, value_name = "PNG")]
    out: PathBuf,
}

fn dragged(text: &str) -> Result<Pin, String> {
    let parts = text.split_once('=').and_then(|(point, at)| Some((point, at.split_once(',')?)));
    let (point, (x, y)) = parts.ok_or("expected POINT=X,Y")?;
    match (point.parse(), x.parse::<f64>(), y.parse::<f64>()) {
        (Ok(point), Ok(x), Ok(y)) if x.is_finite() && y.is_finite() => Ok((point, [x, y])),
        _ => Err("expected POINT=X,Y, a whole number and two numbers".to_owned()),
    }
}

pub(in crate::cli) fn pin(arguments: &PinPoints, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let target = OutputFile::new(&arguments.out, std::slice::from_ref(&arguments.model))?;
    ending(&arguments.out, &["png"])?;
    let model = load(&arguments.model)?;
    let player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    let map = FileMap::new(&player);
    let expected = player.views().point_len();
    for (number, (point, _)) in arguments.pin.iter().enumerate() {
        if *point >= expected {
            bail!("pin {number}: point {point}, of {expected}");
        }
        if arguments.pin[..number].iter().any(|(other, _)| other == point) {
            bail!("pin {number}: point {point} is dragged twice");
        }
    }
    let found = follow(map.object(), &values(&arguments.set)?, &arguments.pin)?;
    let mut played = player.play(&found)?;
    let mut points: Vec<[f64; 2]> =
        played.points.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect();
    let off = |(point, to): &Pin| {
        let at = points[*point];
        (at[0] - to[0]).hypot(at[1] - to[1])
    };
    let left = arguments.pin.iter().map(off).fold(0.0, f64::max);
    bend(&mut points, &arguments.pin);
    for (played, [x, y]) in played.points.iter_mut().zip(&points) {
        (played[0], played[1]) = (*x as f32, *y as f32);
    }
    write(&[(&target, &straight(&player.draw(&played)?.0).png()?)])?;
    let mut text = format!("{}: ", target.named().display());
    let named: Vec<String> =
        found.iter().map(|(name, value)| format!("{name} {value:.3}")).collect();
    text += &format!("{}; {left:.2} px are left for what lies near\n", named.join(", "));
    let json = json!({
        "values": found,
        "left": left,
        "key_views": player.key_names(),
        "weights": played.weights(),
    });
    output.print(&json, &text)
}
