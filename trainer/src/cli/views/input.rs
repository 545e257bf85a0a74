//! Sets of views, maps, parameters, paths and tracked points: arguments, and reading of their files.

use crate::Error;
use crate::cli::{ModelArgs, OfFile};
use crate::formats::json;
use crate::views::inverse::{Found, starts};
use crate::views::object::ObjectMap;
use crate::views::player::Player;
use crate::views::set::{Values, ViewSet, read, read_drawing};
use anyhow::bail;
use serde::Deserialize;
use sinew_runtime::Model;
use std::path::{Path, PathBuf};

/// Model with views, and one of its maps.
#[derive(clap::Args)]
pub(super) struct MapArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Name of the map, if MODEL has several
    #[arg(long)]
    pub(super) map: Option<String>,
}

impl MapArgs {
    /// Opens the map of a model.
    pub(super) fn player<'a>(&self, model: &'a Model<Vec<u8>>) -> anyhow::Result<Player<'a>> {
        Player::new(model, self.map.as_deref()).of(&self.model.file)
    }
}

/// Arguments that name a set of views.
#[derive(clap::Args)]
pub(super) struct SetArguments {
    /// Views as JSON, or the char_cfg.yaml of a drawing with joints, beside its texture.png and mask.png
    pub(super) views: PathBuf,
    /// A mesh as OBJ that gives depths; `mesh_vertex_index` of VIEWS lists the vertex of each point
    #[arg(long, value_name = "OBJ")]
    mesh: Option<PathBuf>,
}

impl SetArguments {
    /// Reads the views.
    pub(super) fn read(&self) -> anyhow::Result<ViewSet> {
        let is_drawing =
            self.views.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
        let set = if is_drawing {
            read_drawing(&self.views)
        } else {
            read(&self.views, self.mesh.as_deref())
        };
        set.of(&self.views)
    }
}

/// Parses `name=number`.
pub(super) fn assignment(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=').ok_or("expected NAME=NUMBER")?;
    match parts.1.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((parts.0.to_owned(), number)),
        _ => Err(format!("expected a number for {}, found \"{}\"", parts.0, parts.1)),
    }
}

/// Collects parameters by name. No parameter may be given twice.
pub(super) fn values(all: &[(String, f64)]) -> anyhow::Result<Values> {
    let mut out = Values::new();
    for (name, value) in all {
        if out.insert(name.clone(), *value).is_some() {
            bail!("parameter \"{name}\" is given twice");
        }
    }
    Ok(out)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPath {
    keys: Vec<Values>,
    #[serde(default = "frames")]
    frames: usize,
}

const fn frames() -> usize {
    24
}

/// Lists the parameters of all frames of a path. The first frame is the first key, and the last frame the last key.
///
/// - `frames`: number of frames, in place of the path's own number.
///
/// # Errors
/// The file cannot be read, or is not a path.
pub(super) fn read_path(file: &Path, frames: Option<usize>) -> anyhow::Result<Vec<Values>> {
    let text = std::fs::read(file).of(file)?;
    let written: WrittenPath = json::read(&text).of(file)?;
    let (keys, len) = (written.keys, frames.unwrap_or(written.frames));
    if keys.is_empty() || len == 0 {
        bail!("{}: expected `keys`, and `frames` above 0", file.display());
    }
    let at = |frame: usize| {
        let way = (keys.len() - 1) as f64 * frame as f64 / (len - 1).max(1) as f64;
        let from = &keys[way as usize];
        let to = keys.get(way as usize + 1).unwrap_or(from);
        let between = |(name, from): (&String, &f64)| {
            (name.clone(), from + way.fract() * (to.get(name).unwrap_or(from) - from))
        };
        from.iter().map(between).collect()
    };
    Ok((0..len).map(at).collect())
}

/// Positions of points in a frame; `None` if hidden.
pub(super) type Points = Vec<Option<[f64; 2]>>;

/// Finds the parameters of tracked points, frame by frame.
pub(super) struct Follower {
    map: ObjectMap,
    near: Vec<Values>,
}

impl Follower {
    /// Makes a follower that starts its search anywhere.
    pub(super) fn new(player: &Player<'_>) -> Self {
        let map = ObjectMap::new(player);
        Self { near: starts(&map.model), map }
    }

    /// Returns the number of points in a frame.
    pub(super) fn point_len(&self) -> usize {
        self.map.outputs.points
    }

    /// Finds the parameters of a frame. The search of the next frame starts from them.
    pub(super) fn find(&mut self, points: &Points) -> Result<Found, Error> {
        let found = self.map.find(points, &self.near)?;
        self.near = vec![found.values.clone()];
        Ok(found)
    }
}

/// Reads frames as CSV: a line for each frame with x and y of each point, empty if a point is hidden. A first line of
/// names is skipped.
pub(super) fn read_track(file: &Path, points: usize) -> anyhow::Result<Vec<Points>> {
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).from_path(file).of(file)?;
    let mut out = Vec::new();
    for (line, record) in reader.records().enumerate() {
        let record = record.of(file)?;
        let cells: Vec<&str> = record.iter().map(str::trim).collect();
        let is_number = |cell: &&str| cell.is_empty() || cell.parse::<f64>().is_ok();
        if line == 0 && !cells.iter().all(is_number) {
            continue;
        }
        let at = format!("{}: line {}", file.display(), line + 1);
        let (expected, found) = (2 * points, cells.len());
        if found != expected {
            bail!("{at}: expected {expected} numbers, found {found}");
        }
        let mut own = Points::new();
        for pair in cells.chunks(2) {
            let numbers = pair.iter().filter_map(|cell| cell.parse().ok());
            own.push(match (pair, &numbers.collect::<Vec<f64>>()[..]) {
                (["", ""], _) => None,
                (_, &[x, y]) if x.is_finite() && y.is_finite() => Some([x, y]),
                _ => bail!("{at}: point {} is no pair of numbers", own.len()),
            });
        }
        if own.iter().flatten().count() < 3 {
            bail!("{at}: fewer than 3 points are seen");
        }
        out.push(own);
    }
    if out.is_empty() { bail!("{}: there are no frames", file.display()) } else { Ok(out) }
}
