//! A skeleton's animation, played by a character from another file.

use super::align;
use super::error::ImportError;
use super::loaded::Loaded;
use super::scene::{rest_frame, rows, unscale};
use super::unposed;
use crate::examples::idle::idle;
use crate::examples::{Examples, ExamplesError, Matrix3x4, Skeleton, Split, Warning};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::scene::{JointNames, Motion, Sampling};
use crate::formats::{FormatError, fbx, gltf};
use crate::numeric::affine::apart;
use crate::space::Conversion;
use nalgebra::Matrix4;
use std::path::Path;

/// Share of the diagonal by which the origins of joints at rest may be elsewhere than the character's, RMS.
const SAME_REST: f64 = 0.01;

/// Plays the animations of a file on a character: its joints, found by name, take the place of the character's
/// frames, with the rest mesh for every posed one. A joint that the file does not have follows its parent; joints that it
/// has in another rest pose, or only as they move, start from the character's.
///
/// # Errors
/// [`ImportError::NoRoot`] and [`ImportError::OtherSkeleton`]; what keeps the scene from being read, with
/// [`SceneError::OtherJoints`](crate::formats::SceneError::OtherJoints) where no name matches.
pub(super) fn play(
    file: &Path,
    mut character: Examples,
    joint_names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Loaded, ExamplesError> {
    let Skeleton { names, parents, rest: own_rest, .. } = &character.skeleton;
    let motion = read(file, names, joint_names, sampling)?;
    let mut places: Vec<Option<usize>> = vec![None; names.len()];
    motion.joints.of.iter().enumerate().for_each(|(own, &joint)| places[joint] = Some(own));
    let mismatch = &motion.joints.mismatch;
    let root = character.skeleton.root();
    if places[root].is_none() {
        let (joint, mismatch) = (names[root].clone(), mismatch.clone());
        return Err(ImportError::NoRoot { joint, mismatch }.into());
    }
    let mut warnings: Vec<Warning> = motion.warnings.iter().cloned().map(Warning::from).collect();
    let found = match found(&motion, &character, &places) {
        Ok(transforms) => transforms,
        Err(error) => {
            let of_character = unposed::transforms(&motion, &character, &places);
            warnings.push(Warning::RestOfCharacter);
            of_character.ok_or(error)?
        }
    };
    let joint_len = names.len();
    let mut transforms: Vec<Matrix3x4> = Vec::new();
    for frame in found.chunks_exact(motion.joints.nodes.len()) {
        let carrier = |joint: usize| {
            let mut upwards = std::iter::successors(Some(joint), |&joint| parents[joint]);
            upwards.find_map(|joint| places[joint])
        };
        transforms.extend((0..joint_len).filter_map(carrier).map(|own| frame[own]));
    }
    let missing = |joint: &usize| places[*joint].is_none();
    let missing: Vec<String> =
        (0..own_rest.len()).filter(missing).map(|joint| names[joint].clone()).collect();
    if !missing.is_empty() {
        let mismatch = mismatch.clone();
        warnings.push(Warning::FollowParents { joints: missing, mismatch });
    }
    let frame_len = transforms.len() / joint_len.max(1);
    character.vertices = character.rest.repeat(frame_len);
    character.split = vec![Split::Train; frame_len];
    character.transforms = transforms;
    warnings.extend(character.unscale_idle_joints());
    warnings.extend(character.validate()?);
    Ok(Loaded { examples: character, clips: motion.clips, warnings })
}

/// Reads how the joints of a character move in a file.
///
/// # Errors
/// [`FormatError`]
pub(super) fn read(
    file: &Path,
    joints: &[String],
    names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, FormatError> {
    match extension(file).as_str() {
        "glb" | "gltf" => gltf::read_motion(file, joints, names, sampling),
        "fbx" => fbx::read_motion(file, joints, names, sampling),
        _ => Err(unknown_format(file, ".glb, .gltf or .fbx")),
    }
}

/// Gives the maps from rest to posed of an animation's joints, frame-major, where the character has them at rest: as a
/// skin of the animation's file binds them, or, without one or elsewhere, as they stand where nothing is animated.
///
/// # Errors
/// [`ImportError::OtherSkeleton`]
fn found(
    motion: &Motion,
    character: &Examples,
    places: &[Option<usize>],
) -> Result<Vec<Matrix3x4>, ImportError> {
    let of = |rest: &[Matrix4<f64>]| {
        let mut found = Found::new(motion, rest, character);
        found.move_to(character, places).map(|()| found.transforms)
    };
    match motion.binds.as_deref().map(of) {
        Some(Ok(transforms)) => Ok(transforms),
        _ => of(&motion.rest),
    }
}

/// The joints of an animation's file, in the order of the character's.
struct Found {
    space: sinew_runtime::format::Space,
    skeleton: Skeleton,
    /// From rest to posed, frame-major.
    transforms: Vec<Matrix3x4>,
}

impl Found {
    /// Begins with the joints at rest in some frames; a scale that all maps have goes into these.
    fn new(motion: &Motion, rest: &[Matrix4<f64>], character: &Examples) -> Self {
        let back = |frame: &Matrix4<f64>| frame.try_inverse().unwrap_or_else(Matrix4::identity);
        let back: Vec<_> = rest.iter().map(back).collect();
        let posed = motion.frames.iter().zip(back.iter().cycle());
        let mut maps: Vec<_> = posed.map(|(frame, back)| frame * back).collect();
        let Skeleton { names, parents, .. } = &character.skeleton;
        let idle = idle(character.joint_weights.as_deref(), parents);
        let idle: Vec<bool> = motion.joints.of.iter().map(|&joint| idle[joint]).collect();
        let scale = unscale(&mut maps, &idle);
        let skeleton = Skeleton {
            names: motion.joints.of.iter().map(|&joint| names[joint].clone()).collect(),
            parents: vec![None; rest.len()],
            rest: rest.iter().map(|frame| rows(&rest_frame(frame, scale))).collect(),
            roots: Vec::new(),
            unplaced: Vec::new(),
        };
        Self { space: motion.space, skeleton, transforms: maps.iter().map(rows).collect() }
    }

    /// Moves the joints to where the character's are: by axes and unit where both are known, else by where they
    /// stand at rest.
    ///
    /// # Errors
    /// [`ImportError::OtherSkeleton`]
    fn move_to(
        &mut self,
        character: &Examples,
        places: &[Option<usize>],
    ) -> Result<(), ImportError> {
        if let Some(conversion) = Conversion::between(&self.space, &character.space) {
            let moved = self.skeleton.rest.iter_mut().chain(&mut self.transforms);
            moved.for_each(|map| *map = conversion.transform(map));
        }
        let own = |joint: usize| origin(&character.skeleton.rest[joint]);
        let pairs = |rest: &[Matrix3x4]| -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
            let pair = |(joint, place): (usize, &Option<usize>)| {
                Some((origin(&rest[(*place)?]), own(joint)))
            };
            places.iter().enumerate().filter_map(pair).unzip()
        };
        let diagonal = character.diagonal();
        let (from, to) = pairs(&self.skeleton.rest);
        if apart(&from, &to) > SAME_REST * diagonal
            && let Ok(similarity) = align::meshes(&from, &to)
        {
            similarity.move_joints(&mut self.skeleton, &mut self.transforms);
        }
        let (from, to) = pairs(&self.skeleton.rest);
        let share = apart(&from, &to) / diagonal;
        if share > SAME_REST {
            return Err(ImportError::OtherSkeleton { percent: 100.0 * share });
        }
        Ok(())
    }
}

fn origin(frame: &Matrix3x4) -> [f64; 3] {
    frame.map(|row| row[3])
}
