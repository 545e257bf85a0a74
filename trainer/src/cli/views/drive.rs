//! `sinew views drive`: pictures of tracked points.

use super::frames::Frames;
use super::input::load;
use crate::cli::{Output, counted};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_trainer::kernel::model::KernelModel;
use sinew_trainer::views::fit::MapOutputs;
use sinew_trainer::views::inverse::{find, starts};
use sinew_trainer::views::player::Player;
use std::path::{Path, PathBuf};

/// Bytes of a parameter that is sent.
const PARAMETER: usize = 4;

/// Draws the object of MODEL as tracked points move: what its parameters are follows from them, wherever they are on
/// the screen and however large.
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
    /// The folder to fill with pictures
    #[arg(short, long, value_name = "FOLDER")]
    out: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let model = load(&arguments.model)?;
    let mut player = Player::new(&model, arguments.map.as_deref()).with_context(about)?;
    if player.views().is_transferred() {
        bail!("{}: its motion is lent: drive its prototype, and animate it along", about());
    }
    let outputs =
        MapOutputs { points: player.views().point_len(), views: player.views().view_len() };
    let track = read(&arguments.track, outputs.points)?;
    let map = KernelModel::from_file(player.map());
    let mut frames = Frames::new(&arguments.out)?;
    let mut near = starts(&map);
    let mut found = Vec::new();
    for (number, points) in track.iter().enumerate() {
        let of = || format!("frame {number}");
        let own = find(&map, outputs, points, &near).with_context(of)?;
        let played = player.play(&own.values).with_context(of)?;
        frames.add(&player.draw(&played)?.0)?;
        // The next frame is near this one.
        near = vec![own.values.clone()];
        found.push(own);
    }
    let bytes = PARAMETER * found.first().map_or(0, |own| own.values.len());
    let off = found.iter().map(|own| own.rms).fold(0.0, f64::max);
    let text = format!(
        "{}: {} of {bytes} bytes each; points are off by {off:.3} px at most, RMS\n",
        arguments.out.display(),
        counted(frames.count(), "frame", "frames"),
    );
    let all: Vec<_> =
        found.iter().map(|own| json!({ "values": own.values, "rms": own.rms })).collect();
    output.print(&json!({ "bytes": bytes, "frames": all }), &text)
}

type Points = Vec<Option<[f64; 2]>>;

fn read(file: &Path, points: usize) -> anyhow::Result<Vec<Points>> {
    let about = || file.display().to_string();
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_path(file)
        .with_context(about)?;
    let mut out = Vec::new();
    for (line, record) in reader.records().enumerate() {
        let record = record.with_context(about)?;
        let is_number = |cell: &str| cell.trim().is_empty() || cell.trim().parse::<f64>().is_ok();
        if line == 0 && !record.iter().all(is_number) {
            continue;
        }
        if record.len() != 2 * points {
            let found = record.len();
            bail!("{}: line {}: expected {} numbers, found {found}", about(), line + 1, 2 * points);
        }
        let cells: Vec<&str> = record.iter().map(str::trim).collect();
        let mut own = Points::new();
        for pair in cells.chunks(2) {
            own.push(match pair {
                ["", ""] => None,
                [x, y] => match (x.parse::<f64>(), y.parse::<f64>()) {
                    (Ok(x), Ok(y)) if x.is_finite() && y.is_finite() => Some([x, y]),
                    _ => bail!(
                        "{}: line {}: point {} is no pair of numbers",
                        about(),
                        line + 1,
                        own.len()
                    ),
                },
                _ => None,
            });
        }
        if own.iter().flatten().count() < 3 {
            bail!("{}: line {}: fewer than 3 points are seen", about(), line + 1);
        }
        out.push(own);
    }
    if out.is_empty() { bail!("{}: there are no frames", about()) } else { Ok(out) }
}
