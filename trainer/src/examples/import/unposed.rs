//! The rest pose of joints whose file has them only as they move: the character's.

use crate::examples::{Examples, Matrix3x4, sample::spread};
use crate::formats::scene::Motion;
use crate::numeric::affine::{joined, parts, to_rows};
use crate::numeric::so3;
use crate::space::Conversion;
use nalgebra::{Matrix3, Matrix4, Vector3};
use sinew_runtime::format::Space;

/// How exporters turn the axes of a joint in its own frame: not at all, or about x as they turn z up to y up.
const TURNS: [[f64; 9]; 3] = [
    [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0],
];
/// Farthest that a joint may be from where its parent has it at rest, RMS over the diagonal.
const SLIDES: f64 = 1e-3;
/// Frames that are looked at.
const SAMPLE: usize = 8;

/// Where a joint is: its axes, and its origin.
type Frame = (Matrix3<f64>, Vector3<f64>);

/// Gives the maps from rest to posed of an animation's joints, frame-major, in the character's space, if every joint
/// stays where the character's own rest pose has it in its parent's frame; `None` where one does not, or where the axes of
/// either are not known.
///
/// - `places`: the animation's joint for each of the character's.
pub(super) fn transforms(
    motion: &Motion,
    character: &Examples,
    places: &[Option<usize>],
) -> Option<Vec<Matrix3x4>> {
    let known = |space: &Space| space.up.is_some() && space.forward.is_some();
    if !known(&motion.space) || !known(&character.space) {
        return None;
    }
    let conversion = Conversion::between(&motion.space, &character.space);
    let conversion = conversion.unwrap_or(Conversion::new(Matrix3::identity(), 1.0));
    if conversion.is_mirrored() {
        return None;
    }
    let frame = |world: &Matrix4<f64>| -> Option<Frame> {
        let (turn, _) = so3::polar(&world.fixed_view::<3, 3>(0, 0).into_owned())?;
        let origin = world.fixed_view::<3, 1>(0, 3).into_owned();
        Some((conversion.axes() * turn, conversion.point(origin.into()).into()))
    };
    let posed: Vec<Frame> = motion.frames.iter().map(frame).collect::<Option<_>>()?;
    let rest: Vec<Frame> = character.skeleton.rest.iter().map(parts).collect();
    let turn = TURNS.map(|turn| Matrix3::from_row_slice(&turn)).into_iter().find(|turn| {
        let slid = slid(turn, &posed, motion.joints.nodes.len(), &rest, &pairs(character, places));
        slid.is_some_and(|slid| slid < SLIDES * character.diagonal())
    })?;
    let mut transforms = Vec::with_capacity(posed.len());
    for frame in posed.chunks_exact(motion.joints.nodes.len()) {
        transforms.extend(frame.iter().enumerate().map(|(own, (axes, origin))| {
            let joint = places.iter().position(|place| *place == Some(own));
            let (rest_axes, rest_origin) = &rest[joint.unwrap_or(character.skeleton.root())];
            let linear = axes * turn.transpose() * rest_axes.transpose();
            to_rows(&joined(&linear, &(origin - linear * rest_origin)))
        }));
    }
    Some(transforms)
}

/// Lists the joints that the animation has, and has one above: both, each by its number in the character and in the
/// animation.
fn pairs(character: &Examples, places: &[Option<usize>]) -> Vec<[(usize, usize); 2]> {
    let parents = &character.skeleton.parents;
    let found = |joint: usize| Some((joint, places[joint]?));
    let pair = |joint: usize| {
        let mut upwards = std::iter::successors(parents[joint], |&joint| parents[joint]);
        Some([upwards.find_map(found)?, found(joint)?])
    };
    (0..places.len()).filter_map(pair).collect()
}

/// Measures how far joints are from where their parents have them at rest, RMS over some frames, when the axes of each are
/// turned so; `None` without any.
fn slid(
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
