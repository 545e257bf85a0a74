//! Tracked points, and the parameters that they show.

use anyhow::{Context, bail};
use sinew_trainer::views::fit::FitError;
use sinew_trainer::views::inverse::{Found, starts};
use sinew_trainer::views::object::FileMap;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::Values;
use std::path::Path;

/// Positions of points in a frame; `None` if hidden.
pub(super) type Points = Vec<Option<[f64; 2]>>;

/// Finds the parameters of tracked points, frame by frame.
pub(super) struct Follower {
    map: FileMap,
    near: Vec<Values>,
}

impl Follower {
    /// Makes a follower that starts its search anywhere.
    pub(super) fn new(player: &Player<'_>) -> Self {
        let map = FileMap::new(player);
        Self { near: starts(map.object().model), map }
    }

    /// Returns the number of points in a frame.
    pub(super) fn point_len(&self) -> usize {
        self.map.object().outputs.points
    }

    /// Finds the parameters of a frame. The search of the next frame starts from them.
    pub(super) fn find(&mut self, points: &Points) -> Result<Found, FitError> {
        let found = self.map.object().find(points, &self.near)?;
        self.near = vec![found.values.clone()];
        Ok(found)
    }
}

/// Reads frames as CSV: a line for each frame with x and y of each point, empty if a point is hidden. A first line of
/// names is skipped.
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
