//! `sinew views render` and `pin`: one picture.

use super::input::{Follower, MapArgs, assignment, read_track, values};
use crate::cli::{OfFile, Output, OutputFile, Report, Run};
use crate::views::object::ObjectMap;
use crate::views::pin::{Pin, bend, follow};
use crate::views::player::straight;
use crate::views::set::Values;
use anyhow::bail;
use std::path::{Path, PathBuf};

/// Draws the object at parameters, or from tracked points
///
/// The runtime draws, as in an engine.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views render head.sinew --set yaw=137 -o head.png")]
pub(in crate::cli) struct Render {
    #[command(flatten)]
    views: MapArgs,
    /// A parameter; angles in degrees; repeatable
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// Tracked points in place of parameters: CSV of one frame, as for `drive`. The parameters follow from the points
    #[arg(long, value_name = "CSV", conflicts_with = "set")]
    points: Option<PathBuf>,
    /// Picture to write
    #[arg(short, long, alias = "out", value_name = "PNG")]
    output: PathBuf,
}

impl Run for Render {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let taken = [&self.views.model.file].into_iter().chain(&self.points);
        let target = OutputFile::new(&self.output, taken)?.ending_in(&["png"])?;
        let model = self.views.model.load()?;
        let player = self.views.player(&model)?;
        let values = match &self.points {
            Some(file) => tracked(&mut Follower::new(&player), file)?,
            None => values(&self.set)?,
        };
        let played = player.play(&values)?;
        let (picture, drawn) = player.draw(&played)?;
        let bytes = straight(&picture).png()?;
        let view = player.views().view_name(played.view).unwrap_or_default();
        Report::default()
            .figure("values", "parameters", &values, "")
            .figure("view", "nearest key view", view, "")
            .json("key_views", player.key_names())
            .json("weights", played.weights())
            .figure("elements", "elements", drawn.element_len, "")
            .figure("flipped", "elements turned over", drawn.flipped_len, "")
            .json("points", &played.points)
            .figure("confidence", "confidence", played.confidence, "")
            .write(&target, &bytes)
    }
}

/// Finds the parameters of the only frame of a file.
fn tracked(follower: &mut Follower, file: &Path) -> anyhow::Result<Values> {
    match &read_track(file, follower.point_len())?[..] {
        [points] => Ok(follower.find(points).of(file)?.values),
        frames => bail!("{}: expected one frame, found {}", file.display(), frames.len()),
    }
}

/// Draws the object with points dragged to places
///
/// The parameters follow first, by their covariance in training. Then the neighbourhood of each point follows.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew views pin head.sinew --set yaw=0 --pin 12=80,64 -o pinned.png"
)]
pub(in crate::cli) struct PinPoints {
    #[command(flatten)]
    views: MapArgs,
    /// A parameter to start from; angles in degrees; repeatable
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// Number of a point and the position to drag it to, in pixels; repeatable
    #[arg(long, value_name = "POINT=X,Y", value_parser = dragged, required = true)]
    pin: Vec<Pin>,
    /// Picture to write
    #[arg(short, long, alias = "out", value_name = "PNG")]
    output: PathBuf,
}

fn dragged(text: &str) -> Result<Pin, String> {
    let parts = text.split_once('=').and_then(|(point, at)| Some((point, at.split_once(',')?)));
    let (point, (x, y)) = parts.ok_or("expected POINT=X,Y")?;
    match (point.parse(), x.parse::<f64>(), y.parse::<f64>()) {
        (Ok(point), Ok(x), Ok(y)) if x.is_finite() && y.is_finite() => Ok((point, [x, y])),
        _ => Err("expected POINT=X,Y, a whole number and two numbers".to_owned()),
    }
}

impl Run for PinPoints {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let target =
            OutputFile::new(&self.output, [&self.views.model.file])?.ending_in(&["png"])?;
        let model = self.views.model.load()?;
        let player = self.views.player(&model)?;
        let map = ObjectMap::new(&player);
        let expected = player.views().point_len();
        for (number, (point, _)) in self.pin.iter().enumerate() {
            if *point >= expected {
                bail!("pin {number}: point {point}, of {expected}");
            }
            if self.pin[..number].iter().any(|(other, _)| other == point) {
                bail!("pin {number}: point {point} is dragged twice");
            }
        }
        let found = follow(&map, &values(&self.set)?, &self.pin)?;
        let mut played = player.play(&found)?;
        let mut points: Vec<[f64; 2]> =
            played.points.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect();
        let distance = |(point, to): &Pin| {
            let at = points[*point];
            (at[0] - to[0]).hypot(at[1] - to[1])
        };
        let left = self.pin.iter().map(distance).fold(0.0, f64::max);
        bend(&mut points, &self.pin);
        for (played, [x, y]) in played.points.iter_mut().zip(&points) {
            (played[0], played[1]) = (*x as f32, *y as f32);
        }
        let bytes = straight(&player.draw(&played)?.0).png()?;
        Report::default()
            .figure("values", "parameters", &found, "")
            .figure("left", "left to bend the neighbourhood by", left, "px")
            .json("key_views", player.key_names())
            .json("weights", played.weights())
            .write(&target, &bytes)
    }
}
