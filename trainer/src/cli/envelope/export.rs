//! `sinew export`: a model and a clip as a GLB that needs no runtime of ours.

use super::levels::{self, AlsoArguments};
use crate::cli::bars::Bars;
use crate::cli::files::{self, OutputFile};
use crate::cli::space::{StatedSpace, TargetSpace};
use crate::cli::{Output, input, printable};
use anyhow::bail;
use serde_json::json;
use sinew_runtime::format::{Axis, Space};
use sinew_trainer::envelope::levels::LevelReport;
use sinew_trainer::envelope::posed::rest;
use sinew_trainer::evaluate::{Character, EvaluateError};
use sinew_trainer::examples::{Clip, ExamplesError, ImportError, JointNames, LoadError, Source};
use sinew_trainer::export::{Export, ExportError, ExportInto, Grafted, IntoError, Stand};
use sinew_trainer::formats::appearance;
use sinew_trainer::space::SpaceRequest;
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
/// Keys stand at the clip's own times. A joint whose keys hold their values keeps its steps, and every other track has
/// two neighbouring keys at a jump. Curves get more keys, and so do helpers that bend between the keys of a scene. Joints
/// are then within 0.02 % of the skeleton's size there, and vertices within 0.1 % of the diagonal. --fps switches that off.
///
/// Names, materials and textures of the meshes of CLIP live through, where it is a scene: all that a GLB or glTF
/// says of them, and of an FBX names, base colours, and pictures that lie beside it.
///
/// Normals are shaded by the joints alone, as engines do it: what the model's tangent coefficients know of them
/// has no place in glTF.
///
/// Meshes given with --also hang on the same joints, so that one prediction drives every level of
/// detail. With --into they are added to the artist's file.
///
/// glTF is right-handed: what a left-handed model moves is mirrored back. Where the model's axes and unit are
/// known, the armature turns and scales the character to glTF's, y up, facing z, in metres, or to what --to-up,
/// --to-forward and --to-unit say. Where they are not, it stands as in the model, and `--up z` turns one that
/// stands along z upright.
///
/// With --into, all that goes into the artist's own GLB or glTF, and the rest of that file stays as it is:
/// materials, textures, morph targets, other meshes and animations, extras and extensions. The meshes whose
/// vertices are the model's, found by place in any axes and unit, take its joints and weights; its own
/// joints, found by name, take keys, and the proxies hang under them. Such a mesh moves to the root of the
/// scene, where glTF wants what a skin moves. Animations that the file has keep their names and move the
/// proxies with their joints alone.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    /// Poses to play, of the character that the model was trained on: a file as `sinew train` takes, all clips of it; or,
    /// with --mesh or --into, a scene that has the skeleton alone
    #[arg(long, value_name = "CLIP")]
    clip: PathBuf,
    /// The file whose mesh, texture coordinates and materials are taken, where CLIP has none, or not these [default:
    /// CLIP; with --into and a CLIP without a mesh, the file of --into]
    #[arg(long, value_name = "CHARACTER")]
    mesh: Option<PathBuf>,
    /// Frames a second that the clip plays at; a scene is sampled at them [default: what its file says, 30, with a
    /// warning, of a .npz that says nothing]
    #[arg(long, value_name = "FPS", value_parser = input::rate, allow_negative_numbers = true)]
    fps: Option<f64>,
    /// The skin whose mesh it plays [default: the model's first]
    #[arg(long, value_name = "NAME")]
    skin: Option<String>,
    /// Replace the prefix FROM of joint names by TO, as in `mixamorig:=`; may be given several times
    ///
    /// The names in CLIP and in the files of --mesh and --into then match the model's. An empty FROM adds a prefix, an
    /// empty TO removes one.
    #[arg(long, value_name = "FROM=TO", value_parser = renaming, allow_hyphen_values = true)]
    rename_joints: Vec<(String, String)>,
    /// Match joint names regardless of case
    #[arg(long)]
    ignore_case: bool,
    #[command(flatten)]
    further: AlsoArguments,
    /// Put it into this file (.glb, .gltf), which holds the character in its rest pose, and leave the rest of
    /// the file alone
    #[arg(
        long,
        value_name = "CHARACTER.glb",
        conflicts_with_all = ["to_up", "to_forward", "to_hand", "to_unit"]
    )]
    into: Option<PathBuf>,
    /// Where to write the file
    #[arg(long, short = 'o', value_name = "OUT.glb")]
    output: PathBuf,
    #[command(flatten)]
    space: StatedSpace,
    #[command(flatten)]
    target: TargetSpace,
}

/// Influences that every engine reads; more come in further sets, which many leave out.
const USUAL_INFLUENCES: usize = 4;

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let mut inputs = Source::file(&arguments.clip).files();
    inputs.push(arguments.model.clone());
    inputs.extend_from_slice(&arguments.further.also);
    inputs.extend(arguments.into.iter().chain(&arguments.mesh).cloned());
    let target = OutputFile::new(&arguments.output, &inputs)?;
    files::ending(&arguments.output, &["glb"])?;
    let model = input::read_model(&arguments.model)?;
    let skin = arguments.skin.as_deref();
    let character =
        Character::find(&model, skin).map_err(|error| blame(error.into(), arguments))?;
    let known =
        (0..character.envelope.joint_len()).filter_map(|j| character.envelope.joint_name(j));
    let known: Vec<String> = known.map(str::to_owned).collect();
    let names = JointNames {
        prefixes: &arguments.rename_joints,
        ignore_case: arguments.ignore_case,
        known: &known,
    };
    let mut input = poses(arguments, names, output)?;
    begin_in_time(&mut input.clips, &arguments.clip, output);
    arguments.space.say(&mut input.examples, &arguments.clip.display().to_string())?;
    let conversion = input.examples.convert_to(&character.space);
    let levels = arguments.further.load(conversion.as_ref(), &character.space, output)?;
    input::move_to(&mut input, &arguments.clip, &rest(&character.skin), output)?;
    let input::LoadedInput { examples, clips, .. } = input;
    // Arrays hold frames alone; a scene has keys, unless a rate was asked for.
    let between = arguments.fps.is_none() && files::ending(&arguments.clip, &["npz"]).is_err();
    let exporting = Bars::busy(output, "exporting");
    let (glb, said) = match &arguments.into {
        None => {
            let stand = stand(&arguments.space, &arguments.target, &character.space)?;
            let dressed = arguments.mesh.as_ref().unwrap_or(&arguments.clip);
            let appearance = appearance::load(dressed)?;
            if !appearance.missing.is_empty() {
                let names = printable(&appearance.missing.join(", "));
                let text = format!("images that cannot be read, and are left out: {names}");
                output.warn(dressed.display(), text);
            }
            let (clips, levels, appearance) = (&clips, &levels, &appearance);
            let export = Export {
                model: &model,
                skin,
                examples: &examples,
                clips,
                between,
                levels,
                appearance,
                stand,
            };
            let exported = export.run().map_err(|error| blame(error.called(clips), arguments))?;
            let names = clips.iter().map(|clip| clip.name.clone()).collect();
            (exported.glb, Said { names, levels: exported.levels, ..Said::default() })
        }
        Some(file) => {
            let (clips, levels) = (&clips, &levels);
            let export = ExportInto {
                model: &model,
                skin,
                examples: &examples,
                clips,
                between,
                levels,
                names,
                file,
            };
            let grafted = export.run().map_err(|error| blame(error.called(clips), arguments))?;
            let Grafted { glb, animations: names, meshes, added_joints, kept_animations, levels } =
                grafted;
            let into = Some(IntoReport { meshes, added_joints, kept_animations });
            (glb, Said { names, levels, into })
        }
    };
    files::write(&[(&target, &glb)])?;
    drop(exporting);
    levels::warn(&said.levels, &arguments.further.also, examples.diagonal_mm(), output);
    let influences = character.skin.influence_len();
    if influences > USUAL_INFLUENCES {
        let sets = format!(
            "vertices follow up to {influences} joints, and many engines read {USUAL_INFLUENCES} of \
             them: train with --influences {USUAL_INFLUENCES} for those"
        );
        output.warn(arguments.output.display(), sets);
    }
    if let (Some(file), Some(into)) = (&arguments.into, &said.into) {
        into.warn(file, output);
    }
    let animations = said.names.iter().zip(&clips);
    let frames = animations
        .clone()
        .map(|(name, clip)| format!("{} ({} frames)", printable(name), clip.times.len()));
    let text = format!(
        "{}wrote {} ({} bytes), {}animations: {}",
        levels::table(&said.levels, examples.diagonal_mm()),
        arguments.output.display(),
        glb.len(),
        said.into.as_ref().map_or(String::new(), |into| {
            format!("meshes: {}, ", printable(&into.meshes.join(", ")))
        }),
        frames.collect::<Vec<_>>().join(", ")
    );
    let record = json!({
        "bytes": glb.len(),
        "animations": animations.map(|(name, clip)| {
            json!({ "name": name, "frames": clip.times.len() })
        }).collect::<Vec<_>>(),
        "levels": levels::as_json(&said.levels, examples.diagonal_mm()),
        "into": said.into,
    });
    output.print(&record, &text)
}

/// Loads what is played, at the rate that is asked for.
fn poses(
    arguments: &Arguments,
    names: JointNames<'_>,
    output: Output,
) -> anyhow::Result<input::LoadedInput> {
    let source = Source { fps: arguments.fps, names, ..Source::file(&arguments.clip) };
    let load = |mesh: Option<&Path>| input::load_motion(source, mesh, output);
    match (&arguments.mesh, &arguments.into) {
        (Some(mesh), _) => load(Some(mesh)),
        // The clip's own mesh first: one without a mesh, or with other joints, needs the other file.
        (None, Some(into)) => match load(None) {
            Ok(input) if input.examples.skeleton.names == names.known => Ok(input),
            Err(error) if !is_bare(&error) => Err(error),
            _ => load(Some(into)),
        },
        (None, None) => load(None),
    }
}

/// Tells whether a scene has no mesh.
fn is_bare(error: &anyhow::Error) -> bool {
    error.downcast_ref::<LoadError>().is_some_and(|error| {
        matches!(error.error, ExamplesError::Import(ImportError::JointsAlone { .. }))
    })
}

/// Moves clips that begin before time 0, which glTF does not have, so that they begin there.
fn begin_in_time(clips: &mut [Clip], file: &Path, output: Output) {
    for clip in clips {
        let Some(begin) = clip.times.first().copied().filter(|begin| *begin < 0.0) else {
            continue;
        };
        clip.times.iter_mut().for_each(|time| *time -= begin);
        let text = format!(
            "clip {} begins at {begin:.4} s, and glTF has no time before 0: it begins there",
            printable(&clip.name)
        );
        output.warn(file.display(), text);
    }
}

/// Parses a change of the beginning of names.
fn renaming(text: &str) -> Result<(String, String), String> {
    let (from, to) = text.split_once('=').ok_or("expected FROM=TO, as mixamorig:=")?;
    match from == to {
        true => Err("expected FROM and TO to differ".to_owned()),
        false => Ok((from.to_owned(), to.to_owned())),
    }
}

/// What is told of an export.
#[derive(Default)]
struct Said {
    /// Names of the animations, one a clip.
    names: Vec<String>,
    levels: Vec<LevelReport>,
    into: Option<IntoReport>,
}

/// What is told of an artist's file.
#[derive(serde::Serialize)]
struct IntoReport {
    meshes: Vec<String>,
    added_joints: Vec<String>,
    kept_animations: Vec<String>,
}

impl IntoReport {
    fn warn(&self, file: &Path, output: Output) {
        if !self.added_joints.is_empty() {
            let joints = printable(&self.added_joints.join(", ")).to_string();
            output.warn(
                file.display(),
                format!("has no nodes of these names, which were added: {joints}"),
            );
        }
        if !self.kept_animations.is_empty() {
            let names = printable(&self.kept_animations.join(", ")).to_string();
            let text = format!("animations that it had move the joints and no proxy: {names}");
            output.warn(file.display(), text);
        }
    }
}

/// Names the file that an error is about.
fn blame(error: ExportError, arguments: &Arguments) -> anyhow::Error {
    let at_fault = match &error {
        ExportError::Model(
            EvaluateError::Frame(_) | EvaluateError::Examples(_) | EvaluateError::JointName { .. },
        )
        | ExportError::Frame(_)
        | ExportError::NoFrames { .. }
        | ExportError::Times { .. } => arguments.clip.display().to_string(),
        ExportError::Model(_) | ExportError::Space(_) => arguments.model.display().to_string(),
        // A file that cannot be read names itself.
        ExportError::Level(_) | ExportError::LeftHanded | ExportError::Into(IntoError::File(_)) => {
            return error.into();
        }
        ExportError::Into(_) => {
            let file = arguments.into.as_ref().unwrap_or(&arguments.output);
            file.display().to_string()
        }
        ExportError::Glb(_) => arguments.output.display().to_string(),
    };
    anyhow::Error::new(error).context(at_fault)
}

/// How a GLB is to stand, by what `export` was told.
fn stand(stated: &StatedSpace, target: &TargetSpace, model: &Space) -> anyhow::Result<Stand> {
    let request = target.request();
    if !request.is_empty() {
        return Ok(Stand::In(request));
    }
    let is_known = model.up.is_some() && model.forward.is_some() && model.unit.is_some();
    match stated.up.map(|up| model.up.unwrap_or(up)) {
        None if is_known => Ok(Stand::In(SpaceRequest::all_of(&Space::GLTF))),
        None | Some(Axis::Y) => Ok(Stand::AsModel),
        Some(Axis::Z) => Ok(Stand::Upright),
        Some(up) => bail!(
            "the character stands along {}: say how it is to stand in the file, with --to-up y \
             --to-forward z",
            up.name()
        ),
    }
}
