//! Loads examples from every supported format.

use super::error::ImportError;
use super::joined::Loaded;
use super::targets::TargetMeshes;
use super::{motion, npz, scene, targets};
use crate::examples::{Examples, ExamplesError, LoadError};
use crate::formats::extension::{check_content, extension, unknown_format};
use crate::formats::scene::{JointNames, SampledScene, Sampling};
use crate::formats::{FormatError, SceneError, fbx, gltf};
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
        }
    }

    /// Lists the files that loading reads, if they exist.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.file.to_owned()];
        if extension(self.file) == "npz" {
            files.push(self.file.with_extension("json"));
        }
        files.extend(self.targets.into_iter().flat_map(targets::files));
        files
    }

    /// Reads the skeleton, mesh and clips of a scene; `None` for an `.npz`.
    fn scene(&self, sampling: &Sampling<'_>) -> Result<Option<SampledScene>, ExamplesError> {
        let read = match extension(self.file).as_str() {
            "npz" => return Ok(None),
            "glb" | "gltf" => gltf::read(self.file, sampling),
            "fbx" => fbx::read(self.file, sampling),
            "abc" | "mdd" | "obj" | "pc2" => return Err(ImportError::MeshesAlone.into()),
            _ => Err(unknown_format(self.file, ".npz, .glb, .gltf or .fbx")),
        };
        Ok(Some(read?))
    }

    /// Checks that no option for scenes is given.
    fn check_whole(&self) -> Result<(), ExamplesError> {
        let given = [("--targets", self.targets.is_some()), ("--fps", self.fps.is_some())];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(ImportError::NotAScene { option }.into()),
            None => Ok(()),
        }
    }

    /// Checks that the content of each file matches its extension.
    fn check_content(&self) -> Result<(), LoadError> {
        for file in [Some(self.file), self.targets].into_iter().flatten() {
            check_content(file)
                .map_err(|error| LoadError { file: file.to_owned(), error: error.into() })?;
        }
        Ok(())
    }

    /// Returns the scene with all clips if only some are requested but the posed meshes cover all.
    fn with_all_clips(&self, scene: SampledScene, targets: Option<&TargetMeshes>) -> SampledScene {
        let Some(held) = targets.map(|targets| targets.meshes.frame_len()) else { return scene };
        if self.clips.is_empty() || held == scene::frame_len(&scene) {
            return scene;
        }
        let all = self.scene(&Sampling { clips: &[], ..self.sampling(false) }).ok().flatten();
        all.filter(|all| held == scene::frame_len(all)).unwrap_or(scene)
    }

    fn sampling(&self, shapes: bool) -> Sampling<'a> {
        Sampling { fps: self.fps, clips: self.clips, shapes, still: self.still, played: false }
    }

    /// Returns the sampling for poses that are played.
    fn played(&self) -> Sampling<'a> {
        Sampling { played: true, ..self.sampling(false) }
    }

    fn blame(&self) -> impl Fn(ExamplesError) -> LoadError {
        |error| LoadError { file: self.file.to_owned(), error }
    }
}

/// Loads examples.
///
/// # Errors
/// A [`LoadError`] with the file that cannot be read, is incomplete, or fails
/// [`Examples::validate`](crate::examples::Examples::validate).
pub fn load(source: &Source<'_>) -> Result<Loaded, LoadError> {
    let blame = source.blame();
    source.check_content()?;
    let sampling = source.sampling(source.targets.is_none());
    let scene = source.scene(&sampling).map_err(&blame)?;
    let Some(scene) = scene else {
        source.check_whole().map_err(&blame)?;
        return npz::load_clips(source.file, &sampling);
    };
    let targets = source.targets.map(targets::read).transpose()?;
    let scene = source.with_all_clips(scene, targets.as_ref());
    let at_fault = source.targets.unwrap_or(source.file);
    let join = || {
        let (examples, clips, mut warnings) = scene::join(scene, targets, &sampling)?;
        warnings.extend(examples.validate()?);
        Ok(Loaded { examples, clips, warnings })
    };
    join().map_err(|error| match error {
        ExamplesError::Import(error) => {
            let file = if error.is_about_targets() { at_fault } else { source.file };
            LoadError { file: file.to_owned(), error: error.into() }
        }
        // The posed positions come from the targets.
        error @ (ExamplesError::NotFinite { array: "vertices", .. }
        | ExamplesError::TooLarge { array: "vertices", .. }) => {
            LoadError { file: at_fault.to_owned(), error: error.of_scene() }
        }
        error => blame(error.of_scene()),
    })
}

/// Loads poses to be played. The source's targets are not read, and the rest mesh replaces posed meshes. Clips have as
/// many frames as linear playback needs: two at a jump, and more than the keys along a curve. An `.npz` plays at the
/// source's rate, if given.
///
/// # Errors
/// As [`load`].
pub fn load_poses(source: &Source<'_>) -> Result<Loaded, LoadError> {
    let blame = source.blame();
    Source::file(source.file).check_content()?;
    let sampling = source.played();
    let scene = source.scene(&sampling).map_err(&blame)?;
    let Some(scene) = scene else {
        let mut loaded = npz::load_played(source.file, &sampling)?;
        rename(&mut loaded.examples, &source.names).map_err(&blame)?;
        return Ok(loaded);
    };
    let (mut examples, clips, mut warnings) = scene::still(scene).map_err(&blame)?;
    rename(&mut examples, &source.names).map_err(&blame)?;
    warnings.extend(examples.validate().map_err(&blame)?);
    Ok(Loaded { examples, clips, warnings })
}

/// Renames the joints to a model's names.
///
/// # Errors
/// [`ImportError::OtherNames`] if the names differ, but another renaming would match.
fn rename(examples: &mut Examples, names: &JointNames<'_>) -> Result<(), ExamplesError> {
    let own = &mut examples.skeleton.names;
    names.rename(own);
    match names.mismatch(own) {
        Some(mismatch) => Err(ImportError::OtherNames { mismatch }.into()),
        None => Ok(()),
    }
}

/// Loads the animations of a scene that may lack a mesh, for a character from another file.
///
/// - `mesh`: file of the character; its frames are not used.
///
/// # Errors
/// As [`load_poses`]; [`ImportError::JointsAlone`] for a scene without a mesh if `mesh` is `None`; errors of joints that differ from the
/// character's.
pub fn load_motion(source: &Source<'_>, mesh: Option<&Path>) -> Result<Loaded, LoadError> {
    let Some(mesh) = mesh else {
        return load_poses(source).map_err(|LoadError { file, error }| {
            let is_bare = matches!(
                &error,
                ExamplesError::Format(FormatError::Scene(SceneError::NoMesh | SceneError::NoSkin))
            );
            if !is_bare {
                return LoadError { file, error };
            }
            let names = &source.names;
            let motion = motion::read(&file, names.known, names, &source.played());
            let mismatch = match motion {
                Ok(motion) => motion.joints.mismatch,
                Err(FormatError::Scene(SceneError::OtherJoints { mismatch, .. })) => mismatch,
                Err(_) => None,
            };
            let error = ImportError::JointsAlone { mismatch };
            LoadError { file, error: error.into() }
        });
    };
    source.check_content()?;
    let names = source.names;
    let character = load_poses(&Source { still: true, names, ..Source::file(mesh) })?.examples;
    motion::play(source.file, character, &names, &source.played()).map_err(source.blame())
}
