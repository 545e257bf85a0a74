//! Skinning matrices from local transforms and the hierarchy.

use super::key::joint_index;
use super::view::Envelope;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Matrix3x4, compose, floats, rows, squared_length, turn};

/// A joint's frame in its parent's, laid out as in C.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LocalTransform {
    /// Quaternion x, y, z, w; it is normalised here.
    pub rotation: [f32; 4],
    /// Origin in the parent's frame, in the units of the model.
    pub translation: [f32; 3],
}

/// Computes the J skinning matrices of a pose given by J local transforms, in the joints' order.
///
/// `out_pose[j] = frame_j inverse_bind_j`, where `frame_j = frame_parent local_j`, the root's local
/// transform being its frame in model space.
///
/// # Errors
/// - [`CallErrorKind::Length`]: `local` or `out_pose` does not hold J elements.
/// - [`CallErrorKind::NonFinite`]: a rotation or translation is not finite.
/// - [`CallErrorKind::ZeroRotation`]: a quaternion's squared length is zero, subnormal or overflows.
pub fn model_space_pose(
    envelope: &Envelope<'_>,
    local: &[LocalTransform],
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    pose_under(None, envelope, local, out_pose)
}

/// Computes what [`model_space_pose`] does, the root's local transform being its frame in a space that `root` carries
/// to model space: a node above the skeleton, or an actor whose palette is to be in world space.
///
/// # Errors
/// Those of [`model_space_pose`], and [`CallErrorKind::NonFinite`] of [`Argument::Root`] if the matrix is not finite.
pub fn model_space_pose_under(
    root: &Matrix3x4,
    envelope: &Envelope<'_>,
    local: &[LocalTransform],
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    check_root(root)?;
    pose_under(Some(root), envelope, local, out_pose)
}

/// Checks that a root's matrix is finite.
pub(super) fn check_root(root: &Matrix3x4) -> Result<(), CallError> {
    if root.as_flattened().iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(CallError::new(CallErrorKind::NonFinite, Argument::Root))
}

#[inline(always)]
fn pose_under(
    root: Option<&Matrix3x4>,
    envelope: &Envelope<'_>,
    local: &[LocalTransform],
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    let expected = envelope.joint_len();
    Argument::Local.check_len(expected, local.len())?;
    Argument::Pose.check_len(expected, out_pose.len())?;
    for (joint, transform) in local.iter().enumerate() {
        if !transform.rotation.iter().chain(&transform.translation).all(|x| x.is_finite()) {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Local).at(joint));
        }
        if !squared_length(transform.rotation).is_normal() {
            return Err(CallError::new(CallErrorKind::ZeroRotation, Argument::Local).at(joint));
        }
    }
    let parents = envelope.parents();
    for joint in envelope.evaluation_order() {
        let (Some(local), Some(parent)) = (local.get(joint), parents.get(joint)) else { continue };
        let mut frame = frame(local);
        let parent = joint_index(parent).and_then(|parent| out_pose.get(parent));
        if let Some(above) = parent.or(root) {
            frame = compose(above, &frame);
        }
        if let Some(out) = out_pose.get_mut(joint) {
            *out = frame;
        }
    }
    for (out, inverse_bind) in out_pose.iter_mut().zip(envelope.bind_words()) {
        *out = compose(out, &rows(&floats(inverse_bind)));
    }
    Ok(())
}

/// Returns the matrix of a local transform.
fn frame(local: &LocalTransform) -> Matrix3x4 {
    let [x, y, z] = turn(local.rotation);
    let [tx, ty, tz] = local.translation;
    let row = |[a, b, c]: [f32; 3], t| [a, b, c, t];
    [row(x, tx), row(y, ty), row(z, tz)]
}
