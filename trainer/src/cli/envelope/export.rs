//! `sinew export`: a model and a clip as a GLB or USD that plays without Sinew's runtime.

use super::levels::{self, AlsoArguments};
use crate::cli::arguments::TargetSpace;
use crate::cli::{
    Bars, ModelArgs, OfFile, Output, OutputFile, Report, Run, StatedSpace, ending, files, input,
    number, printable,
};
use crate::envelope::levels::check_places;
use crate::envelope::posed::rest;
use crate::evaluate::Character;
use crate::examples::{Clip, Curves, JointNames, Loaded, RATES, Source, has_no_mesh, numbered};
use crate::export::{Export, ExportInto, Grafted, Placement, Playback, check_clips};
use crate::formats::appearance;
use crate::space::SpaceRequest;
use crate::{Error, ErrorKind};
use anyhow::bail;
use serde_json::json;
use sinew_runtime::format::{Axis, Space};
use std::path::{Path, PathBuf};

/// Bakes a model and a clip into a GLB or USD for any engine
///
/// Helpers become ordinary joints under the skeleton's joints, the runtime's prediction for every frame becomes their
/// keys, and the mesh is skinned to them. An output that ends in .usda is UsdSkel, as text. Each clip becomes an
/// animation, at the clip's times and in the units of the examples (glTF takes metres). A helper scales along its own
/// axes, which takes two nodes: proxy_N moves, turns and scales, and proxy_N_axes, the joint of the skin, turns the
/// axes back. An engine must multiply the matrices of the nodes, as glTF requires; an engine that keeps only
/// translation, rotation and scale of each joint in model space loses the shear. A joint that stretches has two such
/// nodes under its own, NAME_stretch and NAME_axes. Values of curves are in the extras of the animations.
///
/// Keys are at the clip's own times. A joint whose keys hold their values keeps its steps, and every other track has
/// two neighbouring keys at a jump. Splines get more keys, and so do helpers that bend between the keys of a scene.
/// Joints are then within 0.02 % of the skeleton's size there, and vertices within 0.1 % of the diagonal. --fps
/// disables this.
///
/// If CLIP is a scene, its meshes keep names, materials and textures: everything from a GLB or glTF; from an FBX names,
/// base colours, and pictures in its folder.
///
/// Normals are shaded by the joints alone, as in engines: glTF has no place for the model's tangent coefficients.
///
/// Meshes given with --also follow the exported joints, so that one prediction drives every level of detail. With
/// --into they are added to the artist's file.
///
/// glTF is right-handed: motion of a left-handed model is mirrored. If the model's axes and unit are known, the
/// armature turns and scales the character to glTF's space (y up, facing z, metres), or to that of --to-up,
/// --to-forward and
/// --to-unit. Otherwise the character stands as in the model, and `--up z` turns a character that stands along z
/// upright.
///
/// With --into, everything goes into the artist's own GLB or glTF, and the rest of that file is unchanged: materials,
/// textures, morph targets, other meshes and animations, extras and extensions. Meshes with the model's vertices, found
/// by position in any axes and unit, get its joints and weights. The file's joints, found by name, get keys, and the
/// helpers are added under them. Such a mesh moves to the root of the scene, where glTF wants skinned meshes.
/// Animations of the file keep their names; they move the helpers with their joints only.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew export model.sinew --clip walk.glb -o out.glb")]
pub(in crate::cli) struct ExportArgs {
    #[command(flatten)]
    model: ModelArgs,
    /// Poses to play, of the model's character: a file as for `sinew train`, with all its clips; or, with --mesh or
    /// --into, a scene with the skeleton alone
    #[arg(long, value_name = "CLIP")]
    clip: PathBuf,
    /// File with the mesh, texture coordinates and materials, if CLIP lacks them or has others [default: CLIP; with
    /// --into and a CLIP without a mesh, the file of --into]
    #[arg(long, value_name = "CHARACTER")]
    mesh: Option<PathBuf>,
    /// Frames a second of the clip; a scene is sampled at this rate [default: from the file, else 30 with a warning]
    #[arg(long, value_name = "FPS", value_parser = number(RATES, " frames a second"), allow_negative_numbers = true)]
    fps: Option<f64>,
    /// Curves of a scene: a .csv as for `sinew train` [default: the weights of the scene's shapes]
    #[arg(long, value_name = "FILE")]
    curves_from: Option<PathBuf>,
    /// Skin whose mesh is played [default: the model's first]
    #[arg(long, value_name = "NAME")]
    skin: Option<String>,
    /// File to write, .glb or .usda
    #[arg(short, long, alias = "out", value_name = "OUT")]
    output: PathBuf,
    /// Put everything into this file (.glb, .gltf), which holds the character in its rest pose, and change nothing else
    #[arg(
        long,
        value_name = "CHARACTER.glb",
        conflicts_with_all = ["to_up", "to_forward", "to_hand", "to_unit"]
    )]
    into: Option<PathBuf>,
    /// Replace the prefix FROM of joint names by TO, as `mixamorig:=`; repeatable
    ///
    /// Names in CLIP and in the files of --mesh and --into then match the model's. An empty FROM adds a prefix, an
    /// empty TO removes one.
    #[arg(long, value_name = "FROM=TO", value_parser = renaming, allow_hyphen_values = true)]
    #[arg(help_heading = "Names of joints")]
    rename_joints: Vec<(String, String)>,
    /// Match joint names regardless of case
    #[arg(long, help_heading = "Names of joints")]
    ignore_case: bool,
    #[command(flatten)]
    further: AlsoArguments,
    #[command(flatten)]
    space: StatedSpace,
    #[command(flatten)]
    target: TargetSpace,
}

/// Number of influences that every engine reads. More come in further sets, which many engines ignore.
const USUAL_INFLUENCES: usize = 4;

impl Run for ExportArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let mut inputs = Source::file(&self.clip).files();
        inputs.extend(self.curves_from.clone());
        inputs.push(self.model.file.clone());
        inputs.extend_from_slice(&self.further.also);
        inputs.extend(self.into.iter().chain(&self.mesh).cloned());
        let target = OutputFile::new(&self.output, &inputs)?.ending_in(&["glb", "usda"])?;
        let is_usd = ending(&self.output, &["usda"]).is_ok();
        if let Some(into) = self.into.as_ref().filter(|_| is_usd) {
            bail!("--into {} gives a GLB: name the output .glb", into.display());
        }
        let model = files::read_model(&self.model.file)?;
        let skin = self.skin.as_deref();
        let character = Character::find(&model, skin).of(&self.model.file)?;
        let envelope = &character.envelope;
        let known = (0..envelope.joint_len()).filter_map(|joint| envelope.joint_name(joint));
        let known: Vec<String> = known.map(str::to_owned).collect();
        let names = JointNames {
            prefixes: &self.rename_joints,
            ignore_case: self.ignore_case,
            known: &known,
        };
        let curves = (0..envelope.curve_len()).filter_map(|curve| envelope.curve_name(curve));
        let curves: Vec<String> = curves.map(str::to_owned).collect();
        let mut input = self.poses(names, &curves, output)?;
        begin_at_zero(&mut input.clips, &self.clip, output);
        self.space.set(&mut input.examples, self.clip.display())?;
        let conversion = input.examples.convert_to(&character.space);
        let levels = self.further.load(conversion.as_ref(), &character.space, output)?;
        input::move_to(&mut input, &self.clip, &rest(&character.skin), output)?;
        let Loaded { examples, clips, .. } = input;
        // Arrays hold frames alone. A scene has keys between frames, unless a rate was given.
        let between = self.fps.is_none() && ending(&self.clip, &["npz"]).is_err();
        let exporting = Bars::busy(output, "exporting");
        let (examples, clips, levels) = (&examples, &clips, &levels);
        let playback = Playback { model: &model, skin, examples, clips, between, levels };
        check_clips(clips).of(&self.clip)?;
        // Checked here, because a later error would get the name of the model.
        check_places(levels, examples)?;
        let (bytes, names, levels, into) = match &self.into {
            None => {
                let placement = placement(&self.space, &self.target, &character.space)?;
                let dressed = self.mesh.as_ref().unwrap_or(&self.clip);
                let appearance = &appearance::load(dressed)?;
                if !appearance.missing.is_empty() {
                    let names = printable(&appearance.missing.join(", "));
                    let text = format!("images that cannot be read, and are left out: {names}");
                    output.warn(dressed.display(), text);
                }
                let exported = Export { playback, appearance, placement }.run();
                let exported = exported.map_err(|error| self.blame(error, clips))?;
                let names: Vec<String> = clips.iter().map(|clip| clip.name.clone()).collect();
                let bytes = if is_usd { exported.usda()?.into_bytes() } else { exported.glb };
                (bytes, names, exported.levels, None)
            }
            Some(file) => {
                let grafted = ExportInto { playback, names, file }.run();
                let grafted = grafted.map_err(|error| self.blame(error, clips))?;
                let Grafted { glb, animations, levels, meshes, added_joints, kept_animations } =
                    grafted;
                (glb, animations, levels, Some((meshes, added_joints, kept_animations)))
            }
        };
        drop(exporting);
        let diagonal_mm = examples.diagonal_mm();
        levels::warn(&levels, &self.further.also, diagonal_mm, output);
        let influences = character.skin.influence_len();
        if influences > USUAL_INFLUENCES {
            let sets = format!(
                "vertices follow up to {influences} joints, and many engines read {USUAL_INFLUENCES} of \
                 them: train with --influences {USUAL_INFLUENCES} for those"
            );
            output.warn(self.output.display(), sets);
        }
        if let (Some(file), Some((_, added_joints, kept_animations))) = (&self.into, &into) {
            warn_of(added_joints, kept_animations, file, output);
        }
        let animations = names.iter().zip(clips);
        let frames = animations
            .clone()
            .map(|(name, clip)| format!("{} ({} frames)", printable(name), clip.times.len()));
        let frames = format!("animations: {}", frames.collect::<Vec<_>>().join(", "));
        let as_json =
            |(name, clip): (&String, &Clip)| json!({ "name": name, "frames": clip.times.len() });
        let meshes =
            into.as_ref().map(|(meshes, ..)| format!("meshes: {}", printable(&meshes.join(", "))));
        let into = into.map(|(meshes, added_joints, kept_animations)| {
            json!({
                "meshes": meshes,
                "added_joints": added_joints,
                "kept_animations": kept_animations,
            })
        });
        Ok(Report::default()
            .list("levels", levels::report(&levels, diagonal_mm))
            .write(&target, &bytes)?
            .text(meshes.unwrap_or_default())
            .text(frames)
            .json("animations", animations.map(as_json).collect::<Vec<_>>())
            .json("into", into))
    }
}

impl ExportArgs {
    /// Loads the poses and the model's curves, at the given rate.
    fn poses(
        &self,
        names: JointNames<'_>,
        curves: &[String],
        output: Output,
    ) -> anyhow::Result<Loaded> {
        let curves = if curves.is_empty() { Curves::None } else { Curves::Named(curves) };
        let curves_from = self.curves_from.as_deref();
        let file = Source::file(&self.clip);
        let source = Source { fps: self.fps, names, curves, curves_from, ..file };
        let load = |mesh: Option<&Path>| input::load_motion(source, mesh, output);
        match (&self.mesh, &self.into) {
            (Some(mesh), _) => load(Some(mesh)),
            // The clip's own mesh first. A clip without a mesh, or with other joints, needs the other file.
            (None, Some(into)) => match load(None) {
                Ok(input) if input.examples.skeleton.names == names.known => Ok(input),
                Err(error) if !has_no_mesh(&self.clip) => Err(error),
                _ => load(Some(into)),
            },
            (None, None) => load(None),
        }
    }

    /// Adds the name of the file that an error of an export is about, unless the error names the artist's file.
    fn blame(&self, error: Error, clips: &[Clip]) -> Error {
        let file = match error.kind() {
            _ if error.frame().is_some() => &self.clip,
            // The skeleton is not the model's.
            ErrorKind::Mismatch => &self.clip,
            ErrorKind::Limit | ErrorKind::Write => &self.output,
            // A request for a space that glTF does not have.
            ErrorKind::Unsupported => return error,
            _ => &self.model.file,
        };
        numbered(error, clips).in_file(file)
    }
}

/// Moves clips that begin before time 0 to time 0: glTF has no negative times.
fn begin_at_zero(clips: &mut [Clip], file: &Path, output: Output) {
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

/// Parses a replacement of prefixes.
fn renaming(text: &str) -> Result<(String, String), String> {
    let (from, to) = text.split_once('=').ok_or("expected FROM=TO, as mixamorig:=")?;
    match from == to {
        true => Err("expected FROM and TO to differ".to_owned()),
        false => Ok((from.to_owned(), to.to_owned())),
    }
}

/// Warns of changes of an artist's file.
fn warn_of(added_joints: &[String], kept_animations: &[String], file: &Path, output: Output) {
    for (what, names) in [
        ("has no nodes of these names, which were added", added_joints),
        ("animations that it had move the joints and no helper", kept_animations),
    ] {
        if !names.is_empty() {
            let names = printable(&names.join(", "));
            output.warn(file.display(), format!("{what}: {names}"));
        }
    }
}

/// Returns the position of the character in a GLB, by the arguments and the model's space.
fn placement(
    stated: &StatedSpace,
    target: &TargetSpace,
    model: &Space,
) -> anyhow::Result<Placement> {
    let request = target.request();
    if !request.is_empty() {
        return Ok(Placement::In(request));
    }
    let is_known = model.up.is_some() && model.forward.is_some() && model.unit.is_some();
    match stated.up.map(|up| model.up.unwrap_or(up)) {
        None if is_known => Ok(Placement::In(SpaceRequest::all_of(&Space::GLTF))),
        None | Some(Axis::Y) => Ok(Placement::AsModel),
        Some(Axis::Z) => Ok(Placement::Upright),
        Some(up) => bail!(
            "the character stands along {}: say how it is to stand in the file, with --to-up y \
             --to-forward z",
            up.name()
        ),
    }
}
