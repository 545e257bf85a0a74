//! Where examples come from: one way in for every format.

use std::path::{Path, PathBuf};

use super::error::ImportError;
use super::loaded::Loaded;
use super::targets::TargetMeshes;
use super::{motion, npz, scene, targets};
use crate::examples::{Examples, ExamplesError, LoadError};
use crate::formats::extension::{check_content, extension, unknown_format};
use crate::formats::scene::{JointNames, SampledScene, Sampling, SceneError};
use crate::formats::{FormatError, fbx, gltf};

/// The files that examples are read from, and how.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Skeleton, rest mesh and poses: `.npz` with everything, or a scene in `.glb`, `.gltf` or
    /// `.fbx`.
    pub file: &'a Path,
    /// Posed meshes of a scene from another file, one a frame of the poses.
    pub targets: Option<&'a Path>,
    /// Frames a second at which a scene's clips are sampled, at their keys where none is given; of poses to be played,
    /// also at which the frames of an `.npz` follow.
    pub fps: Option<f64>,
    /// The clips to read; all of them where none is given.
    pub clips: &'a [String],
    /// Whether the one frame is what a scene shows without any clip.
    pub still: bool,
    /// How the names of the joints become a model's, where poses are to be played.
    pub names: JointNames<'a>,
}

impl<'a> Source<'a> {
    /// Names a file that needs nothing beside it.
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

    /// Lists the files that a load reads, where they are there.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.file.to_owned()];
        if extension(self.file) == "npz" {
            files.push(self.file.with_extension("json"));
        }
        files.extend(self.targets.into_iter().flat_map(targets::files));
        files
    }

    /// Gives the skeleton, mesh and clips of a scene; none where the file is complete in itself.
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

    /// Checks that nothing is given that only goes with a scene.
    fn check_whole(&self) -> Result<(), ExamplesError> {
        let given = [("--targets", self.targets.is_some()), ("--fps", self.fps.is_some())];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(ImportError::NotAScene { option }.into()),
            None => Ok(()),
        }
    }

    /// Checks that each file holds what its ending says.
    fn check_content(&self) -> Result<(), LoadError> {
        for file in [Some(self.file), self.targets].into_iter().flatten() {
            check_content(file)
                .map_err(|error| LoadError { file: file.to_owned(), error: error.into() })?;
        }
        Ok(())
    }

    /// Gives the scene with all of its clips, where some are asked for and the posed meshes are of all.
    fn as_held(&self, scene: SampledScene, targets: Option<&TargetMeshes>) -> SampledScene {
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

    /// Samples clips as they are to be played.
    fn played(&self) -> Sampling<'a> {
        Sampling { played: true, ..self.sampling(false) }
    }

    fn blame(&self) -> impl Fn(ExamplesError) -> LoadError {
        |error| LoadError { file: self.file.to_owned(), error }
    }
}

/// Reads examples.
///
/// # Errors
/// A [`LoadError`] that names the file at fault: it cannot be read, does not hold what is needed, or
/// holds what fails [`Examples::validate`](crate::examples::Examples::validate).
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
    let scene = source.as_held(scene, targets.as_ref());
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
        // What is posed comes from the targets.
        error @ (ExamplesError::NotFinite { array: "vertices", .. }
        | ExamplesError::TooLarge { array: "vertices", .. }) => {
            LoadError { file: at_fault.to_owned(), error: error.of_scene() }
        }
        error => blame(error.of_scene()),
    })
}

/// Reads poses to be played; of a scene without a skin the rest mesh stands in for every posed one. The source's
/// targets are not read. Clips of a scene have as many frames as playing them linearly takes: two where a pose jumps, and
/// more than keys along a curve. The frames of an `.npz` play at the source's rate, where it has one.
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

/// Calls the joints as a model's.
///
/// # Errors
/// [`ImportError::OtherNames`] where they are not, and would be if they were renamed.
fn rename(examples: &mut Examples, names: &JointNames<'_>) -> Result<(), ExamplesError> {
    let own = &mut examples.skeleton.names;
    names.rename(own);
    match names.mismatch(own) {
        Some(mismatch) => Err(ImportError::OtherNames { mismatch }.into()),
        None => Ok(()),
    }
}

/// Reads the animations of a scene that may hold joints alone, for a character whose mesh another file has.
///
/// - `mesh`: that file, of whose frames none is kept.
///
/// # Errors
/// As [`load_poses`]; [`ImportError::JointsAlone`] of a scene without a mesh where no other is given; and those of joints
/// that are not the character's.
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
