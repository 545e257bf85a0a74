//! Loads examples from every supported format.

use super::clips::frame_len;
use super::curves::{self, SampledCurves};
use super::joined::Loaded;
use super::targets::TargetMeshes;
use super::{motion, npz, scene, targets};
use crate::examples::validate::Origin;
use crate::examples::{Clip, Curves, Examples};
use crate::formats::extension::{check_content, extension, unknown_format};
use crate::formats::scene::{CurveTrack, JointNames, SampledScene, Sampling};
use crate::formats::{fbx, gltf};
use crate::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Files of examples, and options of loading.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Skeleton, rest mesh and poses: a complete `.npz`, or a scene (`.glb`, `.gltf`, `.fbx`).
    pub file: &'a Path,
    /// Posed meshes of a scene from another file, one per frame.
    pub targets: Option<&'a Path>,
    /// Frames per second for sampling a scene's clips; `None` samples at the keys. When poses are played, also the rate
    /// of an `.npz`.
    pub fps: Option<f64>,
    /// Names of the clips to read; empty for all clips.
    pub clips: &'a [String],
    /// Whether to read a single frame: the scene without any clip.
    pub still: bool,
    /// Renaming of joints to a model's names, when poses are played.
    pub names: JointNames<'a>,
    /// Choice of the curves.
    pub curves: Curves<'a>,
    /// Table of a scene's curves (`.csv`), in place of the weights of its shapes.
    pub curves_from: Option<&'a Path>,
}

impl<'a> Source<'a> {
    /// Creates a source from a single file.
    pub fn file(file: &'a Path) -> Self {
        Self {
            file,
            targets: None,
            fps: None,
            clips: &[],
            still: false,
            names: JointNames::default(),
            curves: Curves::Usual,
            curves_from: None,
        }
    }

    /// Lists the files that loading reads, if they exist.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.file.to_owned()];
        if extension(self.file) == "npz" {
            files.push(self.file.with_extension("json"));
        }
        files.extend(self.targets.into_iter().flat_map(targets::files));
        files.extend(self.curves_from.map(Path::to_owned));
        files
    }

    /// Reads the skeleton, mesh and clips of a scene; `None` for an `.npz`.
    fn scene(&self, sampling: &Sampling<'_>) -> Result<Option<SampledScene>, Error> {
        match extension(self.file).as_str() {
            "npz" => Ok(None),
            "glb" | "gltf" => gltf::read(self.file, sampling).map(Some),
            "fbx" => fbx::read(self.file, sampling).map(Some),
            "abc" | "mdd" | "obj" | "pc2" => Err(npz::meshes_alone()),
            _ => Err(unknown_format(self.file, ".npz, .glb, .gltf or .fbx")),
        }
    }

    /// Checks that no option for scenes is given.
    fn check_whole(&self) -> Result<(), Error> {
        let given = [
            ("--targets", self.targets.is_some()),
            ("--fps", self.fps.is_some()),
            ("--curves-from", self.curves_from.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::unsupported(format!(
                "{option} goes with a scene (.glb, .gltf, .fbx); an .npz holds its own poses, meshes and curves"
            ))),
            None => Ok(()),
        }
    }

    /// Checks that the content of each file matches its extension.
    fn check_content(&self) -> Result<(), Error> {
        for file in [Some(self.file), self.targets, self.curves_from].into_iter().flatten() {
            check_content(file).map_err(|error| error.in_file(file))?;
        }
        Ok(())
    }

    /// Returns the scene with all clips if only some are requested but the posed meshes cover all.
    fn with_all_clips(&self, scene: SampledScene, targets: Option<&TargetMeshes>) -> SampledScene {
        let Some(held) = targets.map(|targets| targets.meshes.frame_len()) else { return scene };
        if self.clips.is_empty() || held == frame_len(&scene.clips) {
            return scene;
        }
        let all = self.scene(&Sampling { clips: &[], ..self.sampling(false) }).ok().flatten();
        all.filter(|all| held == frame_len(&all.clips)).unwrap_or(scene)
    }

    fn sampling(&self, shapes: bool) -> Sampling<'a> {
        let of_shapes = matches!(self.curves, Curves::All | Curves::Named(_));
        let curves = of_shapes && self.curves_from.is_none();
        let Self { fps, clips, still, .. } = *self;
        Sampling { fps, clips, shapes, still, played: false, curves }
    }

    /// Returns the chosen curves of a scene.
    fn curves(&self, tracks: &[CurveTrack], clips: &[Clip]) -> Result<SampledCurves, Error> {
        match self.curves_from {
            Some(table) => curves::of_table(table, clips, self.curves),
            None => curves::of_shapes(tracks, self.curves),
        }
    }

    /// Returns the sampling for poses that are played.
    fn played(&self) -> Sampling<'a> {
        Sampling { played: true, ..self.sampling(false) }
    }
}

/// Loads examples.
///
/// # Errors
/// A file cannot be read, is incomplete, or fails [`Examples::validate`](crate::examples::Examples::validate); the
/// error names the file.
pub fn load(source: &Source<'_>) -> Result<Loaded, Error> {
    source.check_content()?;
    let load = || {
        let sampling = source.sampling(source.targets.is_none());
        let Some(scene) = source.scene(&sampling)? else {
            source.check_whole()?;
            let (mut loaded, _) = npz::load_clips(source.file, &sampling)?;
            loaded.examples.choose_curves(source.curves)?;
            return Ok(loaded);
        };
        let targets = source.targets.map(targets::read).transpose()?;
        let scene = source.with_all_clips(scene, targets.as_ref());
        let curves = source.curves(&scene.curves, &scene.clips)?;
        let loaded = scene::join(scene, curves, targets, &sampling)?;
        loaded.checked(&Origin { posed_file: source.targets, ..Origin::SCENE })
    };
    load().map_err(|error: Error| error.in_file(source.file))
}

/// Loads poses to be played. The source's targets are not read, and the rest mesh replaces posed meshes. Clips have as
/// many frames as linear playback needs: two at a jump, and more than the keys along a curve. An `.npz` plays at the
/// source's rate, if given.
///
/// # Errors
/// As [`load`].
pub fn load_poses(source: &Source<'_>) -> Result<Loaded, Error> {
    Source::file(source.file).check_content()?;
    let load = || {
        let sampling = source.played();
        let Some(scene) = source.scene(&sampling)? else {
            let mut loaded = npz::load_played(source.file, &sampling)?;
            loaded.examples.choose_curves(source.curves)?;
            rename(&mut loaded.examples, &source.names)?;
            return Ok(loaded);
        };
        let curves = source.curves(&scene.curves, &scene.clips)?;
        let mut loaded = scene::still(scene)?;
        curves.put(&mut loaded.examples);
        rename(&mut loaded.examples, &source.names)?;
        loaded.checked(&Origin::SCENE)
    };
    load().map_err(|error: Error| error.in_file(source.file))
}

/// Renames the joints to a model's names.
///
/// # Errors
/// The names differ, but another renaming would match.
fn rename(examples: &mut Examples, names: &JointNames<'_>) -> Result<(), Error> {
    let own = &mut examples.skeleton.names;
    names.rename(own);
    match names.mismatch(own) {
        Some(mismatch) => Err(Error::mismatch(format!(
            "its joints have other names than the model's: {mismatch}"
        ))),
        None => Ok(()),
    }
}

/// Loads the animations of a scene that may lack a mesh, for a character from another file.
///
/// - `mesh`: file of the character; its frames are not used.
///
/// # Errors
/// As [`load_poses`]. Without `mesh`, also for a scene without a mesh ([`has_no_mesh`]); with `mesh`, also for joints
/// that differ from the character's.
pub fn load_motion(source: &Source<'_>, mesh: Option<&Path>) -> Result<Loaded, Error> {
    let Some(mesh) = mesh else {
        return load_poses(source).map_err(|error| {
            let is_missing = error.kind() == ErrorKind::Missing;
            match is_missing.then(|| joints_alone(source.file)).flatten() {
                Some(found) => no_mesh(found, &source.names).in_file(source.file),
                None => error,
            }
        });
    };
    source.check_content()?;
    let names = source.names;
    let still = Source { still: true, names, curves: Curves::None, ..Source::file(mesh) };
    let character = load_poses(&still)?.examples;
    let play = || {
        let motion =
            motion::read(source.file, &character.skeleton.names, &names, &source.played())?;
        let curves = source.curves(&motion.curves, &motion.clips)?;
        motion::play(motion, character, curves)
    };
    play().map_err(|error| error.in_file(source.file))
}

/// Returns whether a file is a scene whose joints carry no mesh.
pub fn has_no_mesh(file: &Path) -> bool {
    joints_alone(file).is_some()
}

/// Returns the names of the joints of a scene without a mesh; `None` for other files.
fn joints_alone(file: &Path) -> Option<Vec<String>> {
    match extension(file).as_str() {
        "glb" | "gltf" => gltf::joints_alone(file),
        "fbx" => fbx::joints_alone(file),
        _ => None,
    }
}

/// Returns the error of a scene without a mesh.
///
/// - `found`: names of its joints.
fn no_mesh(mut found: Vec<String>, names: &JointNames<'_>) -> Error {
    names.rename(&mut found);
    let mismatch = names.mismatch(&found).map_or(String::new(), |why| format!("; {why}"));
    Error::missing(format!(
        "holds joints and no mesh: give a file that has the character's mesh as well, with --mesh or --into{mismatch}"
    ))
}
