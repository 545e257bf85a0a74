//! Further meshes as the command line names them, and how they follow.

use crate::cli::Output;
use crate::cli::column::padded;
use anyhow::bail;
use serde_json::{Value, json};
use sinew_runtime::format::Space;
use sinew_trainer::envelope::levels::{Level, LevelReport, NEAR, OWN};
use sinew_trainer::formats::MeshFile;
use sinew_trainer::space::{Conversion, beside, written};
use std::path::{Path, PathBuf};

/// Further meshes.
#[derive(clap::Args, serde::Serialize)]
pub(in crate::cli) struct AlsoArguments {
    /// A further mesh on the same joints (.obj, .glb, .gltf, .fbx), of any topology, in the rest pose of the examples;
    /// may be given several times
    ///
    /// One prediction then drives all of them: levels of detail, garments. Weights come from the nearest points of the
    /// model's surface, and are fitted to where that surface carries them. Other axes or another unit are recognised
    /// where one way alone brings the mesh there; --also-axes says which, where several do.
    #[arg(long, value_name = "LOD")]
    pub(in crate::cli) also: Vec<PathBuf>,
    /// Where the axes of the --also meshes come from, and a scale, as "(x, -z, y) x 0.01": once for all, or once for
    /// each, in their order [default: recognised]
    #[arg(long, value_name = "AXES", requires = "also", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    also_axes: Vec<Conversion>,
}

impl AlsoArguments {
    /// Reads the meshes, named after their files. Each is converted from the space that its file states, or as the
    /// examples were.
    ///
    /// - `conversion`: the change of axes and unit of the examples.
    /// - `space`: their axes and unit after it.
    pub(in crate::cli) fn load(
        &self,
        conversion: Option<&Conversion>,
        space: &Space,
        output: Output,
    ) -> anyhow::Result<Vec<Level>> {
        let (files, given) = (self.also.len(), self.also_axes.len());
        if given > 1 && given != files {
            bail!(
                "--also-axes: expected one for all meshes or one for each of {files}, found {given}"
            );
        }
        let mut levels = Vec::new();
        for (number, file) in self.also.iter().enumerate() {
            if file.is_dir() {
                bail!("{}: is a folder, expected a mesh (.obj, .glb, .gltf, .fbx)", file.display());
            }
            let MeshFile { mut mesh, space: own, warnings } = MeshFile::read(file)?;
            warnings.iter().for_each(|warning| output.warn(file.display(), warning));
            let by_file = own.and_then(|own| Conversion::between(&own, space));
            let known = if own.is_some() { by_file.as_ref() } else { conversion };
            let axes = self.also_axes.get(if given > 1 { number } else { 0 });
            known.into_iter().chain(axes).for_each(|conversion| mesh.convert(conversion));
            levels.push(Level { name: name_of(file), mesh, is_placed: axes.is_some() });
        }
        Ok(levels)
    }

    /// Checks that skins, which are named after the files of their meshes, would have different names.
    pub(in crate::cli) fn check_names(&self) -> anyhow::Result<()> {
        for (number, file) in self.also.iter().enumerate() {
            let name = name_of(file);
            let other = self.also[..number].iter().find(|other| name_of(other) == name);
            let other = match other {
                Some(other) => other.display().to_string(),
                None if name == OWN => "the examples' own mesh".to_owned(),
                None => continue,
            };
            bail!(
                "{}: its skin would be called {name}, as that of {other}: rename one of the files",
                file.display()
            );
        }
        Ok(())
    }
}

/// Names the skin of a file.
fn name_of(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Warns of meshes that were moved or are far from the model's surface, and of vertices that do not belong to the
/// surface.
///
/// - `diagonal_mm`: the rest diagonal; `None` where the unit is not known.
pub(in crate::cli) fn warn(
    levels: &[LevelReport],
    files: &[PathBuf],
    diagonal_mm: Option<f64>,
    output: Output,
) {
    for (level, file) in levels.iter().zip(files) {
        if let Some(how) = &level.moved {
            let moved =
                format!("came in other axes or another unit than the model and was moved: {how}");
            output.warn(file.display(), moved);
        }
        let percent = level.distance_percent;
        if percent > 100.0 * NEAR {
            let mm = beside(percent, diagonal_mm);
            let away = format!(
                "half of its vertices are more than {percent:.1} %{mm} of the diagonal from the model's surface, \
                 expected {:.0} % at most: look whether it is a mesh of this character, in the rest pose, axes and unit \
                 of the examples",
                100.0 * NEAR
            );
            output.warn(file.display(), away);
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
