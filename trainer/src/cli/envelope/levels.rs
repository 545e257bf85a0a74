//! Further meshes as the command line names them, and how they follow.

use crate::cli::Output;
use crate::cli::column::padded;
use anyhow::bail;
use serde_json::{Value, json};
use sinew_trainer::envelope::levels::{Level, LevelReport};
use sinew_trainer::formats::obj;
use sinew_trainer::space::{Conversion, written};
use std::path::{Path, PathBuf};

/// Reads further meshes, each called as its file, and converts them as the examples were.
pub(in crate::cli) fn load(
    files: &[PathBuf],
    conversion: Option<&Conversion>,
) -> anyhow::Result<Vec<Level>> {
    let mut levels = files.iter().map(|file| level(file)).collect::<anyhow::Result<Vec<_>>>()?;
    for level in &mut levels {
        if let Some(conversion) = conversion {
            level.mesh.convert(conversion);
        }
    }
    Ok(levels)
}

fn level(file: &Path) -> anyhow::Result<Level> {
    if file.is_dir() {
        bail!("{}: is a folder, expected an .obj file", file.display());
    }
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Level { name, mesh: obj::load(file)? })
}

/// Warns of meshes that were moved, and of vertices that do not belong to the model's surface.
pub(in crate::cli) fn warn(levels: &[LevelReport], files: &[PathBuf], output: Output) {
    for (level, file) in levels.iter().zip(files) {
        if let Some(how) = &level.moved {
            let moved =
                format!("came in other axes or another unit than the model and was moved: {how}");
            output.warn(file.display(), moved);
        }
        if level.far > 0 {
            let far = format!(
                "vertices further than 10 % of the diagonal from the model's surface, which follow \
                 their nearest point: {}",
                level.far
            );
            output.warn(file.display(), far);
        }
    }
}

/// Gives how meshes follow as JSON, with lengths in millimetres where the diagonal is known.
pub(in crate::cli) fn as_json(levels: &[LevelReport], diagonal_mm: Option<f64>) -> Value {
    let level = |level: &LevelReport| {
        let mut out = json!(level);
        if let Some(diagonal) = diagonal_mm {
            out["fitted_mm"] = json!(level.fitted_percent / 100.0 * diagonal);
        }
        out
    };
    levels.iter().map(level).collect()
}

/// Describes how meshes follow, on a mesh with this diagonal; nothing where there is none.
pub(in crate::cli) fn table(levels: &[LevelReport], diagonal_mm: Option<f64>) -> String {
    if levels.is_empty() {
        return String::new();
    }
    let [name, vertices, distance, transferred, fitted] =
        ["RMS error, % of the diagonal", "vertices", "distance", "transferred", "fitted"];
    let mm = diagonal_mm.map_or("", |_| "  fitted, mm");
    let mut out =
        format!("{name:<30}{vertices:>10}{distance:>12}{transferred:>14}{fitted:>10}{mm}\n");
    for level in levels {
        let LevelReport { vertices, distance_percent, transferred_percent, fitted_percent, .. } =
            level;
        let name = padded(&level.name, 30);
        let length = |diagonal: f64| written(fitted_percent / 100.0 * diagonal);
        let mm = diagonal_mm.map_or(String::new(), |mm| format!("{:>12}", length(mm)));
        out += &format!(
            "{name}{vertices:>10}{distance_percent:>12.4}{transferred_percent:>14.4}\
             {fitted_percent:>10.4}{mm}\n"
        );
    }
    out
}
