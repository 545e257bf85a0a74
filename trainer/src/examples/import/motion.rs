//! A skeleton's animation, played by a character from another file.

use super::align;
use super::error::ImportError;
use super::loaded::Loaded;
use super::scene::rows;
use super::unposed;
use crate::examples::{Examples, ExamplesError, Matrix3x4, Skeleton, Split, Warning};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::scene::{Motion, Sampling};
use crate::formats::{fbx, gltf};
use crate::numeric::points::apart;
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
/// [`ImportError::NoJoints`], [`ImportError::NoRoot`] and [`ImportError::OtherSkeleton`]; what keeps the scene from
/// being read.
pub(super) fn play(
    file: &Path,
    mut character: Examples,
    sampling: &Sampling<'_>,
) -> Result<Loaded, ExamplesError> {
    let Skeleton { names, parents, rest: own_rest, .. } = &character.skeleton;
    let motion = match extension(file).as_str() {
        "glb" | "gltf" => gltf::read_motion(file, names, sampling)?,
        "fbx" => fbx::read_motion(file, names, sampling)?,
        _ => return Err(unknown_format(file, ".glb, .gltf or .fbx").into()),
    };
    let place = |name: &String| motion.names.iter().position(|own| own == name);
    let places: Vec<Option<usize>> = names.iter().map(place).collect();
    if places.iter().all(Option::is_none) {
        return Err(ImportError::NoJoints { joints: names.join(", ") }.into());
    }
    let root = character.skeleton.root();
    if places[root].is_none() {
        return Err(ImportError::NoRoot { joint: names[root].clone() }.into());
    }
    let mut warnings: Vec<Warning> = motion.warnings.iter().cloned().map(Warning::from).collect();
    let mut found = Found::new(&motion);
    if let Err(error) = found.move_to(&character, &places) {
        let Some(transforms) = unposed::transforms(&motion, &character, &places) else {
            return Err(error.into());
        };
        found.transforms = transforms;
        warnings.push(Warning::RestOfCharacter);
    }
    let joint_len = names.len();
    let mut transforms: Vec<Matrix3x4> = Vec::new();
    for frame in found.transforms.chunks_exact(motion.names.len()) {
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
        warnings.push(Warning::FollowParents { joints: missing });
    }
    let frame_len = transforms.len() / joint_len.max(1);
    character.vertices = character.rest.repeat(frame_len);
    character.split = vec![Split::Train; frame_len];
    character.transforms = transforms;
    warnings.extend(character.validate()?);
    Ok(Loaded { examples: character, clips: motion.clips, warnings })
}

/// The joints of an animation's file, in its order.
struct Found {
    space: sinew_runtime::format::Space,
    skeleton: Skeleton,
    /// From rest to posed, frame-major.
    transforms: Vec<Matrix3x4>,
}

impl Found {
    fn new(motion: &Motion) -> Self {
        let back = |frame: &Matrix4<f64>| frame.try_inverse().unwrap_or_else(Matrix4::identity);
        let back: Vec<_> = motion.rest.iter().map(back).collect();
        let posed = motion.frames.chunks_exact(back.len());
        let posed = posed.flat_map(|frame| frame.iter().zip(&back).map(|(a, b)| rows(&(a * b))));
        let skeleton = Skeleton {
            names: motion.names.clone(),
            parents: vec![None; motion.names.len()],
            rest: motion.rest.iter().map(rows).collect(),
            roots: Vec::new(),
            unplaced: Vec::new(),
        };
        Self { space: motion.space, skeleton, transforms: posed.collect() }
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
