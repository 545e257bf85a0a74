//! Tracked points, and the parameters that they show.

use anyhow::{Context, bail};
use sinew_trainer::views::fit::FitError;
use sinew_trainer::views::inverse::{Found, starts};
use sinew_trainer::views::object::FileMap;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::Values;
use std::path::Path;

/// Where points are in a frame; none that are not seen.
pub(super) type Points = Vec<Option<[f64; 2]>>;

/// Finds the parameters of tracked points, frame by frame.
pub(super) struct Follower {
    map: FileMap,
    near: Vec<Values>,
}

impl Follower {
    /// Begins with a map, anywhere.
    pub(super) fn new(player: &Player<'_>) -> Self {
        let map = FileMap::new(player);
        Self { near: starts(map.object().model), map }
    }

    /// Returns how many points there are in a frame.
    pub(super) fn point_len(&self) -> usize {
        self.map.object().outputs.points
    }

    /// Finds a frame's parameters; the next frame's are looked for near them.
    pub(super) fn find(&mut self, points: &Points) -> Result<Found, FitError> {
        let found = self.map.object().find(points, &self.near)?;
        self.near = vec![found.values.clone()];
        Ok(found)
    }
}

/// Reads frames, CSV: a line a frame, x and y of each of some points, empty where one is not seen; a first line of names
/// is passed over.
pub(super) fn read_track(file: &Path, points: usize) -> anyhow::Result<Vec<Points>> {
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
