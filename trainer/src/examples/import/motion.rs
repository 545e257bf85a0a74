//! Plays a skeleton's animation on a character from another file.

use super::align;
use super::curves::SampledCurves;
use super::joined::Loaded;
use super::scene::{rest_frame, rows, unscale};
use crate::Error;
use crate::examples::distortion::STRETCHES;
use crate::examples::joints::idle;
use crate::examples::validate::Origin;
use crate::examples::{Examples, Matrix3x4, Skeleton, Split, Warning, spread};
use crate::formats::extension::{extension, unknown_format};
use crate::formats::scene::{JointNames, Motion, Sampling};
use crate::formats::{fbx, gltf};
use crate::numeric::affine::{apart, joined, parts, to_rows};
use crate::numeric::so3;
use crate::space::Conversion;
use nalgebra::{Matrix3, Matrix4, Vector3};
use sinew_runtime::format::Space;
use std::path::Path;

/// Largest distance between the joint origins of animation and character at rest, RMS relative to the diagonal.
const SAME_REST: f64 = 0.01;

/// Rotations of joint axes that exporters apply in the joint's own frame: none, or about x to convert z up to y up.
const TURNS: [[f64; 9]; 3] = [
    [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0],
];
/// Largest distance of joints from their rest position in the parent's frame, RMS relative to the diagonal.
const MAX_DRIFT: f64 = 1e-3;
/// Number of sampled frames.
const SAMPLE: usize = 8;

/// Axes and origin of a joint.
type Frame = (Matrix3<f64>, Vector3<f64>);

/// Plays animations on a character. Joints are matched by name, and the rest mesh replaces every posed
/// mesh. A joint that the file lacks follows its parent. If the file has another rest pose or none, the character's
/// rest pose is used.
///
/// # Errors
/// The root is missing, or the rest poses differ.
pub(super) fn play(
    motion: Motion,
    mut character: Examples,
    curves: SampledCurves,
) -> Result<Loaded, Error> {
    let Skeleton { names, parents, .. } = &character.skeleton;
    let mut places: Vec<Option<usize>> = vec![None; names.len()];
    motion.joints.of.iter().enumerate().for_each(|(own, &joint)| places[joint] = Some(own));
    let mismatch = &motion.joints.mismatch;
    let root = character.skeleton.root();
    if places[root].is_none() {
        return Err(Error::missing(format!(
            "has no joint {}, the root of the character's: {}",
            names[root],
            mismatch.as_deref().unwrap_or("export the whole skeleton")
        )));
    }
    let mut warnings: Vec<Warning> = motion.warnings.iter().cloned().map(Warning::from).collect();
    let found = match from_own_rest(&motion, &character, &places) {
        Ok(transforms) => transforms,
        Err(error) => {
            let of_character = of_character_rest(&motion, &character, &places);
            warnings.push(Warning::RestOfCharacter);
            of_character.ok_or(error)?
        }
    };
    let carrier = |joint: usize| {
        let mut upwards = std::iter::successors(Some(joint), |&joint| parents[joint]);
        upwards.find_map(|joint| places[joint])
    };
    let carriers: Vec<usize> = (0..names.len()).filter_map(carrier).collect();
    let frames = found.chunks_exact(motion.joints.nodes.len());
    let transforms = frames.flat_map(|frame| carriers.iter().map(move |&own| frame[own])).collect();
    let missing = names.iter().zip(&places).filter(|(_, place)| place.is_none());
    let joints: Vec<String> = missing.map(|(name, _)| name.clone()).collect();
    if !joints.is_empty() {
        warnings.push(Warning::FollowParents { joints, mismatch: mismatch.clone() });
    }
    character.transforms = transforms;
    let frame_len = character.transforms.len() / character.joint_len().max(1);
    character.vertices = character.rest.repeat(frame_len);
    character.split = vec![Split::Train; frame_len];
    curves.put(&mut character);
    warnings.extend(character.unscale());
    Loaded { examples: character, clips: motion.clips, warnings }.checked(&Origin::SCENE)
}

/// Reads the motion of a character's joints from a file.
///
/// # Errors
/// The file cannot be read, or no node is a joint of the character.
pub(super) fn read(
    file: &Path,
    joints: &[String],
    names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, Error> {
    match extension(file).as_str() {
        "glb" | "gltf" => gltf::read_motion(file, joints, names, sampling),
        "fbx" => fbx::read_motion(file, joints, names, sampling),
        _ => Err(unknown_format(file, ".glb, .gltf or .fbx")),
    }
}

/// Computes the maps from rest pose to pose of an animation's joints, frame-major, if its rest pose matches the
/// character's. The rest pose is the bind pose of a skin in the file, or else the pose without animation.
///
/// # Errors
/// The rest poses differ.
fn from_own_rest(
    motion: &Motion,
    character: &Examples,
    places: &[Option<usize>],
) -> Result<Vec<Matrix3x4>, Error> {
    let of = |rest: &[Matrix4<f64>]| from_rest(motion, rest, character, places);
    match motion.binds.as_deref().map(of) {
        Some(Ok(transforms)) => Ok(transforms),
        _ => of(&motion.rest),
    }
}

/// Computes the maps from a rest pose to the poses of an animation's joints, frame-major. A common scale of all maps
/// moves into the rest pose. Then the joints move onto the character's joints: by axes and unit if both are known, else
/// by the rest origins.
///
/// - `places`: the animation's joint of each character joint.
///
/// # Errors
/// The rest poses differ.
fn from_rest(
    motion: &Motion,
    rest: &[Matrix4<f64>],
    character: &Examples,
    places: &[Option<usize>],
) -> Result<Vec<Matrix3x4>, Error> {
    let back = |frame: &Matrix4<f64>| frame.try_inverse().unwrap_or_else(Matrix4::identity);
    let back: Vec<_> = rest.iter().map(back).collect();
    let posed = motion.frames.iter().zip(back.iter().cycle());
    let mut maps: Vec<_> = posed.map(|(frame, back)| frame * back).collect();
    let idle = idle(character.joint_weights.as_deref(), &character.skeleton.parents);
    let idle: Vec<bool> = motion.joints.of.iter().map(|&joint| idle[joint]).collect();
    let at_rest: Vec<_> = motion.rest.iter().zip(&back).map(|(own, back)| own * back).collect();
    let scale = unscale(&mut maps, &at_rest, &idle);
    let mut rest: Vec<Matrix3x4> =
        rest.iter().map(|frame| rows(&rest_frame(frame, scale))).collect();
    let mut transforms: Vec<Matrix3x4> = maps.iter().map(rows).collect();
    if let Some(conversion) = Conversion::between(&motion.space, &character.space) {
        let moved = rest.iter_mut().chain(&mut transforms);
        moved.for_each(|map| *map = conversion.transform(map));
    }
    let pairs = |rest: &[Matrix3x4]| -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
        let all = places.iter().zip(&character.skeleton.rest);
        all.filter_map(|(place, own)| Some((origin(&rest[(*place)?]), origin(own)))).unzip()
    };
    let diagonal = character.diagonal();
    let (from, to) = pairs(&rest);
    if apart(&from, &to) > SAME_REST * diagonal
        && let Ok(similarity) = align::meshes(&from, &to)
    {
        similarity.move_joints(&mut rest, &mut transforms);
    }
    let (from, to) = pairs(&rest);
    let share = apart(&from, &to) / diagonal;
    if share > SAME_REST {
        let percent = 100.0 * share;
        return Err(Error::mismatch(format!(
            "its joints at rest are not the character's: off by {percent:.1} % of the diagonal; export the skeleton \
             in its rest pose, with the animation, or give --mesh a file that says its axes"
        )));
    }
    Ok(transforms)
}

/// Computes the maps from rest pose to pose of an animation's joints from the character's rest pose, frame-major, in
/// the character's space. `None` if a joint leaves its rest position in the parent's frame, if a joint's stretch changes
/// (its stretch at rest is unknown), or if axes are unknown.
///
/// - `places`: the animation's joint of each character joint.
fn of_character_rest(
    motion: &Motion,
    character: &Examples,
    places: &[Option<usize>],
) -> Option<Vec<Matrix3x4>> {
    let known = |space: &Space| space.up.is_some() && space.forward.is_some();
    if !known(&motion.space) || !known(&character.space) {
        return None;
    }
    let conversion = Conversion::between(&motion.space, &character.space);
    let conversion = conversion.unwrap_or(Conversion { axes: Matrix3::identity(), scale: 1.0 });
    if conversion.is_mirrored() {
        return None;
    }
    let joint_len = motion.joints.nodes.len();
    let polar = |world: &Matrix4<f64>| so3::polar(&world.fixed_view::<3, 3>(0, 0).into_owned());
    let first: Vec<_> = motion.frames.iter().take(joint_len).map(polar).collect::<Option<_>>()?;
    let frame = |(index, world): (usize, &Matrix4<f64>)| -> Option<Frame> {
        let (turn, stretch) = polar(world)?;
        let still = &first[index % joint_len].1;
        let is_still = (stretch - still).amax() <= STRETCHES * still.amax();
        let origin = world.fixed_view::<3, 1>(0, 3).into_owned();
        is_still.then(|| (conversion.axes * turn, conversion.point(origin.into()).into()))
    };
    let posed: Vec<Frame> = motion.frames.iter().enumerate().map(frame).collect::<Option<_>>()?;
    let rest: Vec<Frame> = character.skeleton.rest.iter().map(parts).collect();
    let turn = TURNS.map(|turn| Matrix3::from_row_slice(&turn)).into_iter().find(|turn| {
        let drift = drift(turn, &posed, joint_len, &rest, &pairs(character, places));
        drift.is_some_and(|drift| drift < MAX_DRIFT * character.diagonal())
    })?;
    let mut transforms = Vec::with_capacity(posed.len());
    for frame in posed.chunks_exact(joint_len) {
        transforms.extend(frame.iter().enumerate().map(|(own, (axes, origin))| {
            let joint = places.iter().position(|place| *place == Some(own));
            let (rest_axes, rest_origin) = &rest[joint.unwrap_or(character.skeleton.root())];
            let linear = axes * turn.transpose() * rest_axes.transpose();
            to_rows(&joined(&linear, &(origin - linear * rest_origin)))
        }));
    }
    Some(transforms)
}

/// Lists pairs of a joint in the animation and its nearest ancestor there: (ancestor, joint), each with its number in
/// the character and in the animation.
fn pairs(character: &Examples, places: &[Option<usize>]) -> Vec<[(usize, usize); 2]> {
    let parents = &character.skeleton.parents;
    let found = |joint: usize| Some((joint, places[joint]?));
    let pair = |joint: usize| {
        let mut upwards = std::iter::successors(parents[joint], |&joint| parents[joint]);
        Some([upwards.find_map(found)?, found(joint)?])
    };
    (0..places.len()).filter_map(pair).collect()
}

/// Measures the distance of joints from their rest position in the parent's frame, RMS over sampled frames, for joint
/// axes rotated by `turn`. `None` without pairs.
fn drift(
    turn: &Matrix3<f64>,
    posed: &[Frame],
    joint_len: usize,
    rest: &[Frame],
    pairs: &[[(usize, usize); 2]],
) -> Option<f64> {
    let seen = |(axes, origin): &Frame, other: &Frame| axes.transpose() * (other.1 - origin);
    let frames = spread(posed.len() / joint_len.max(1), SAMPLE);
    let squares: Vec<f64> = frames
        .iter()
        .flat_map(|frame| {
            let posed = &posed[frame * joint_len..][..joint_len];
            pairs.iter().map(|[(parent, above), (joint, own)]| {
                let at_rest = seen(&rest[*parent], &rest[*joint]);
                (at_rest - turn * seen(&posed[*above], &posed[*own])).norm_squared()
            })
        })
        .collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

fn origin(frame: &Matrix3x4) -> [f64; 3] {
    frame.map(|row| row[3])
}
