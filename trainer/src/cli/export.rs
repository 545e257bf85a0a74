//! `sinew export`: a model and a clip as a GLB that needs no runtime of ours.

use super::bars::Bars;
use super::files::{self, Target};
use super::{Output, input};
use anyhow::bail;
use clap::ValueEnum;
use serde_json::json;
use sinew_runtime::Model;
use sinew_trainer::evaluate::{EvaluateError, envelope, rest};
use sinew_trainer::examples::{Clip, Source, obj};
use sinew_trainer::export::{ExportError, Level, LevelReport, Up, export};
use std::path::{Path, PathBuf};

/// Bakes a model and a clip into a GLB that plays in any engine
///
/// Proxies become ordinary joints under the skeleton's, the runtime's prediction for every frame
/// becomes their keys, and the mesh is skinned to them: an animation a clip, at the clip's times, in
/// the units of the examples (glTF takes metres). A proxy scales along axes of its own, which takes
/// two nodes: proxy_N moves, turns and scales, and proxy_N_axes, the joint of the skin, turns the
/// axes back. An engine must multiply the nodes' matrices, as glTF asks; one that keeps only a move,
/// a turn and a scale of each joint in model space loses the shear.
///
/// Meshes given with --also hang on the same joints, so that one prediction drives every level of
/// detail. Their weights come from the nearest points of the model's surface and are then fitted to
/// where that surface carries them in the clip's frames.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    /// Poses to play, of the character that the model was trained on: a file as `sinew train` takes, all clips of it
    #[arg(long, value_name = "CLIP")]
    clip: PathBuf,
    /// A further mesh on the same joints, of any topology, in the rest pose of the examples; may be
    /// given several times
    #[arg(long, value_name = "LOD.obj")]
    also: Vec<PathBuf>,
    /// The axis along which the character stands in the examples; glTF has y
    #[arg(long, value_enum, value_name = "AXIS", default_value_t = UpName::Y)]
    up: UpName,
    /// Where to write the file
    #[arg(long, short = 'o', value_name = "OUT.glb")]
    output: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum UpName {
    Y,
    Z,
}

/// Influences that every engine reads; more come in further sets, which many leave out.
const USUAL_INFLUENCES: usize = 4;

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let mut inputs = Source::file(&arguments.clip).files();
    inputs.push(arguments.model.clone());
    inputs.extend_from_slice(&arguments.also);
    let target = Target::new(&arguments.output, &inputs)?;
    let model = input::read_model(&arguments.model)?;
    let levels =
        arguments.also.iter().map(|file| level(file)).collect::<anyhow::Result<Vec<_>>>()?;
    let rest = envelope(&model)
        .map(|envelope| rest(&envelope))
        .map_err(|error| blame(error.into(), arguments))?;
    let input::Input { examples, clips, .. } = input::load_poses(&arguments.clip, &rest, output)?;
    let up = match arguments.up {
        UpName::Y => Up::Y,
        UpName::Z => Up::Z,
    };
    let exporting = Bars::busy(output, "exporting");
    let exported =
        export(&model, &examples, &clips, &levels, up).map_err(|error| blame(error, arguments))?;
    files::write(&[(&target, &exported.glb)])?;
    drop(exporting);
    for (level, file) in exported.levels.iter().zip(&arguments.also) {
        if level.far > 0 {
            let far = format!(
                "vertices further than 10 % of the diagonal from the model's surface, which follow \
                 their nearest point: {}",
                level.far
            );
            output.warn(file.display(), far);
        }
    }
    let influences = Model::from_bytes(&model)?.envelope().map_or(0, |e| e.influence_len());
    if influences > USUAL_INFLUENCES {
        let sets = format!(
            "vertices follow up to {influences} joints, and many engines read {USUAL_INFLUENCES} of \
             them: train with --influences {USUAL_INFLUENCES} for those"
        );
        output.warn(arguments.output.display(), sets);
    }
    let text = format!(
        "{}wrote {} ({} bytes), animations: {}",
        table(&exported.levels),
        arguments.output.display(),
        exported.glb.len(),
        names(&clips)
    );
    let record = json!({
        "bytes": exported.glb.len(),
        "animations": clips.iter().map(|clip| {
            json!({ "name": clip.name, "frames": clip.times.len() })
        }).collect::<Vec<_>>(),
        "levels": exported.levels,
    });
    output.print(&record, &text)
}

/// Reads a further mesh.
fn level(file: &Path) -> anyhow::Result<Level> {
    if file.is_dir() {
        bail!("{}: is a folder, expected an .obj file", file.display());
    }
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Level { name, mesh: obj::load(file)? })
}

/// Names the file that an error is about.
fn blame(error: ExportError, arguments: &Arguments) -> anyhow::Error {
    let at_fault = match &error {
        ExportError::Model(EvaluateError::Frame { .. } | EvaluateError::Examples(_))
        | ExportError::NoFrames { .. }
        | ExportError::Times { .. } => arguments.clip.display().to_string(),
        ExportError::Model(_) => arguments.model.display().to_string(),
        ExportError::LevelFar { .. } => return error.into(),
        ExportError::TooLarge { .. } | ExportError::Glb(_) => {
            arguments.output.display().to_string()
        }
    };
    anyhow::Error::new(error).context(at_fault)
}

fn names(clips: &[Clip]) -> String {
    let name =
        |clip: &Clip| format!("{} ({} frames)", super::printable(&clip.name), clip.times.len());
    clips.iter().map(name).collect::<Vec<_>>().join(", ")
}

fn table(levels: &[LevelReport]) -> String {
    if levels.is_empty() {
        return String::new();
    }
    let [name, vertices, distance, transferred, fitted] =
        ["RMS error, % of the diagonal", "vertices", "distance", "transferred", "fitted"];
    let mut out = format!("{name:<30}{vertices:>10}{distance:>12}{transferred:>14}{fitted:>10}\n");
    for level in levels {
        let LevelReport { vertices, distance_percent, transferred_percent, fitted_percent, .. } =
            level;
        let name = super::printable(&level.name);
        out += &format!(
            "{name:<30}{vertices:>10}{distance_percent:>12.4}{transferred_percent:>14.4}\
             {fitted_percent:>10.4}\n"
        );
    }
    out
}
