//! Further meshes on the joints of a model: arguments, warnings and errors.

use crate::cli::{Output, Report};
use crate::envelope::levels::{Level, LevelReport, NEAR, OWN};
use crate::formats::MeshFile;
use crate::space::{Conversion, beside, written};
use anyhow::bail;
use sinew_runtime::format::Space;
use std::path::{Path, PathBuf};

/// Further meshes.
#[derive(clap::Args, serde::Serialize)]
#[command(next_help_heading = "Meshes")]
pub(super) struct AlsoArguments {
    /// Further mesh on the joints (.obj, .glb, .gltf, .fbx), of any topology, in the rest pose; repeatable
    ///
    /// One prediction then drives all meshes: levels of detail, garments. Weights come from the nearest points of the
    /// model's surface, and are fitted to the motion of that surface. Other axes or another unit are recognised if only
    /// one conversion brings the mesh there; --also-axes chooses among several.
    #[arg(long, value_name = "LOD")]
    pub(super) also: Vec<PathBuf>,
    /// Axes of the --also meshes, and a scale, as "(x, -z, y) x 0.01": once for all, or once for each in
    /// order [default: recognised]
    #[arg(long, value_name = "AXES", requires = "also", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    also_axes: Vec<Conversion>,
}

impl AlsoArguments {
    /// Reads the meshes, named after their files. Each is converted from the space that its file states, else as the
    /// examples were.
    ///
    /// - `conversion`: conversion of the examples.
    /// - `space`: axes and unit of the examples after the conversion.
    pub(super) fn load(
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

    /// Checks that skins, which are named after their files, have different names.
    ///
    /// # Errors
    /// Names the file, and the other mesh of that name.
    pub(super) fn check_names(&self) -> anyhow::Result<()> {
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

/// Returns the name of a file's skin.
fn name_of(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Warns of meshes that were converted or are far from the model's surface, and of vertices far from the surface.
///
/// - `diagonal_mm`: diagonal of the rest mesh; `None` if the unit is not known.
pub(super) fn warn(
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

/// Returns figures of further meshes, with lengths in millimetres if the diagonal is known.
pub(super) fn report(levels: &[LevelReport], diagonal_mm: Option<f64>) -> Vec<Report> {
    let level = |level: &LevelReport| {
        let report = Report::of(level)
            .show("name", "RMS error, % of the diagonal", "")
            .show("vertices", "vertices", "")
            .show("distance_percent", "distance", "")
            .show("transferred_percent", "transferred", "")
            .show("fitted_percent", "fitted", "");
        match diagonal_mm {
            Some(diagonal) => {
                let mm = level.fitted_percent / 100.0 * diagonal;
                report.shown("fitted_mm", "fitted, mm", mm, written(mm))
            }
            None => report,
        }
    };
    levels.iter().map(level).collect()
}
