//! Skinning matrices from the frames of a larger skeleton.

use super::bind::FOLDED;
use super::key::joint_index;
use super::local::check_root;
use super::view::Envelope;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Matrix3x4, compose, floats, rows};

/// Gathers the J skinning matrices of a pose from the frames of the caller's skeleton:
/// `out_pose[j] = root world[map[j]] inverse_bind_j`; a joint that is folded has its parent's.
///
/// - `map`: J numbers, as [`Envelope::bind_joints`] gives them.
/// - `world`: the frames of the skeleton's joints after its hierarchy pass, all in one space and in the unit of the model.
/// - `root`: carries that space to the one in which the palette is wanted: model space for bounds and for accuracy
///   far from the origin, by the inverse of the actor's matrix where `world` is world space. `None` where it is the
///   same.
///
/// # Errors
/// - [`CallErrorKind::Length`]: `map` or `out_pose` does not hold J elements.
/// - [`CallErrorKind::OutOfRange`]: a joint's number is none of `world`'s.
/// - [`CallErrorKind::NoRoot`]: the root is folded.
/// - [`CallErrorKind::NonFinite`]: `root` is not finite, or a frame that is gathered; the index is its number in `world`.
pub fn gather_pose(
    envelope: &Envelope<'_>,
    map: &[u32],
    world: &[Matrix3x4],
    root: Option<&Matrix3x4>,
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    let joint_len = envelope.joint_len();
    Argument::Joints.check_len(joint_len, map.len())?;
    Argument::Pose.check_len(joint_len, out_pose.len())?;
    root.map_or(Ok(()), check_root)?;
    for (joint, place) in map.iter().enumerate() {
        check_place(envelope, joint, *place, world)?;
    }
    for joint in envelope.evaluation_order() {
        let frame = map.get(joint).and_then(|place| world.get(*place as usize));
        let parent = || joint_index(envelope.parents().get(joint)?);
        let matrix = match (frame, envelope.bind_words().get(joint)) {
            (Some(frame), Some(bind)) => {
                let frame = root.map_or(*frame, |root| compose(root, frame));
                Some(compose(&frame, &rows(&floats(bind))))
            }
            _ => parent().and_then(|parent| out_pose.get(parent)).copied(),
        };
        if let (Some(out), Some(matrix)) = (out_pose.get_mut(joint), matrix) {
            *out = matrix;
        }
    }
    Ok(())
}

/// Checks that a joint's frame is there and finite, or its parent's stands for it.
fn check_place(
    envelope: &Envelope<'_>,
    joint: usize,
    place: u32,
    world: &[Matrix3x4],
) -> Result<(), CallError> {
    let error = |kind, argument| Err(CallError::new(kind, argument));
    if place == FOLDED {
        let no_root = error(CallErrorKind::NoRoot, Argument::Joints);
        return if joint == envelope.root() { no_root.map_err(|e| e.at(joint)) } else { Ok(()) };
    }
    let Some(frame) = world.get(place as usize) else {
        let most = world.len().saturating_sub(1);
        let error = CallError::new(CallErrorKind::OutOfRange, Argument::Joints);
        return Err(error.at(joint).values(most, place as usize));
    };
    if frame.as_flattened().iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(CallError::new(CallErrorKind::NonFinite, Argument::World).at(place as usize))
}
