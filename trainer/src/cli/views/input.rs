//! Sets, models, parameters and paths as the command line names them.

use crate::cli::input::read_model;
use anyhow::{Context, bail};
use serde::Deserialize;
use sinew_runtime::Model;
use sinew_trainer::views::set::{Values, ViewSet, read, read_drawing};
use std::path::{Path, PathBuf};

/// Arguments that name a set of views.
#[derive(clap::Args)]
pub(super) struct SetArguments {
    /// Views as JSON, or the char_cfg.yaml of a drawing with joints, beside its texture.png and mask.png
    views: PathBuf,
    /// A mesh as OBJ that gives depths; `mesh_vertex_index` of VIEWS lists the vertex of each point
    #[arg(long, value_name = "OBJ")]
    mesh: Option<PathBuf>,
}

impl SetArguments {
    /// Returns the file of the views.
    pub(super) fn file(&self) -> &Path {
        &self.views
    }

    /// Reads the views.
    pub(super) fn read(&self) -> anyhow::Result<ViewSet> {
        let is_drawing =
            self.views.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
        let set = if is_drawing {
            read_drawing(&self.views)
        } else {
            read(&self.views, self.mesh.as_deref())
        };
        set.with_context(|| self.views.display().to_string())
    }
}

/// Loads a model file.
pub(super) fn load(path: &Path) -> anyhow::Result<Model<Vec<u8>>> {
    Model::from_bytes(read_model(path)?).with_context(|| path.display().to_string())
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
    let about = || file.display().to_string();
    let text = std::fs::read(file).with_context(about)?;
    let written: WrittenPath = serde_json::from_slice(&text).with_context(about)?;
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
