//! Paths of parameters, as `animate` and `export` take them.

use anyhow::{Context, bail};
use serde::Deserialize;
use sinew_trainer::views::set::Values;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    keys: Vec<Values>,
    #[serde(default = "frames")]
    frames: usize,
}

const fn frames() -> usize {
    24
}

/// Lists the parameters of all frames of a path. The first frame is the first key, the last frame the last key.
///
/// - `frames`: how many, in place of the path's own number.
///
/// # Errors
/// If the file cannot be read, or is no path.
pub(super) fn read(file: &Path, frames: Option<usize>) -> anyhow::Result<Vec<Values>> {
    let about = || file.display().to_string();
    let text = std::fs::read(file).with_context(about)?;
    let written: Written = serde_json::from_slice(&text).with_context(about)?;
    let (keys, len) = (written.keys, frames.unwrap_or(written.frames));
    if keys.is_empty() || len == 0 {
        bail!("{}: expected `keys`, and `frames` above 0", about());
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
