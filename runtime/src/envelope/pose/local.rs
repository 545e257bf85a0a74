//! Skinning matrices from local transforms and the hierarchy, and the rest pose as local transforms.

use super::arrays::is_finite;
use crate::envelope::view::{Envelope, joint_index};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{
    Matrix3x4, columns, compose, floats, inverse, quaternion, rows, squared_length, turn,
};
use crate::numeric::sqrt;

/// Frame of a joint in its parent's frame, laid out as in C.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LocalTransform {
    /// Quaternion x, y, z, w of any length but 0: [`model_space_pose`] normalises the quaternion.
    pub rotation: [f32; 4],
    /// Origin in the parent's frame, in the units of the model.
    pub translation: [f32; 3],
}

impl Default for LocalTransform {
    /// Returns the identity: the joint is at its parent.
    fn default() -> Self {
        Self { rotation: [0.0, 0.0, 0.0, 1.0], translation: [0.0; 3] }
    }
}

/// Computes the J skinning matrices of a pose from J local transforms.
///
/// `out_pose[j] = frame_j inverse_bind_j` with `frame_j = frame_parent local_j`. The local transform of the root is
/// the root's frame in model space.
///
/// - `local`: J local transforms, in the order of the joints.
/// - `out_pose`: J skinning matrices, rest to posed, in model space.
///
/// # Errors
/// - [`CallErrorKind::Length`]: `local` or `out_pose` does not hold J elements.
/// - [`CallErrorKind::NonFinite`]: a rotation or translation is not finite.
/// - [`CallErrorKind::ZeroRotation`]: the squared length of a quaternion is zero, subnormal or overflows.
pub fn model_space_pose(
    envelope: &Envelope<'_>,
    local: &[LocalTransform],
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    pose_under(None, envelope, local, out_pose)
}

/// Computes the J skinning matrices of a pose below a given transform.
///
/// Use this function for a node above the skeleton, or for an actor whose palette must be in world space. All but
/// `root` is as for [`model_space_pose`].
///
/// - `root`: carries the space of the root's local transform to the space of the pose.
///
/// # Errors
/// - The errors of [`model_space_pose`].
/// - [`CallErrorKind::NonFinite`] of [`Argument::Root`]: `root` is not finite.
pub fn model_space_pose_under(
    root: &Matrix3x4,
    envelope: &Envelope<'_>,
    local: &[LocalTransform],
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    check_root(root)?;
    pose_under(Some(root), envelope, local, out_pose)
}

/// Checks that the matrix of a root is finite.
pub(super) fn check_root(root: &Matrix3x4) -> Result<(), CallError> {
    if is_finite(root) {
        return Ok(());
    }
    Err(CallError::new(CallErrorKind::NonFinite, Argument::Root))
}

impl<'a> Envelope<'a> {
    /// Returns a joint's rest frame in its parent's rest frame; for the root in model space.
    ///
    /// [`crate::model_space_pose`] turns the J rest locals into the rest pose. An animation replaces some of the J
    /// rest locals.
    pub fn rest_local(&self, joint: usize) -> Option<LocalTransform> {
        let mut frame = self.rest_frame(joint)?;
        if let Some(bind) = self.parent(joint).and_then(|parent| self.inverse_bind(parent)) {
            frame = compose(&bind, &frame);
        }
        let [x, y, z, translation] = columns(&frame);
        let ([x, y, z], w) = quaternion(&[x, y, z]);
        let length = sqrt(squared_length([x, y, z, w]));
        Some(LocalTransform { rotation: [x, y, z, w].map(|value| value / length), translation })
    }

    /// Lists the J rest frames, each in the frame of the joint's parent.
    pub fn rest_locals(&self) -> impl Iterator<Item = LocalTransform> + use<'a> {
        let envelope = *self;
        (0..self.joint_len()).filter_map(move |joint| envelope.rest_local(joint))
    }

    /// Returns a joint's rest frame in model space: the inverse of the inverse bind matrix.
    pub fn rest_frame(&self, joint: usize) -> Option<Matrix3x4> {
        self.inverse_bind(joint).map(|bind| inverse(&bind))
    }

    /// Lists the J inverse bind matrices.
    pub fn inverse_binds(&self) -> impl ExactSizeIterator<Item = Matrix3x4> + use<'a> {
        self.bind_words().iter().take(self.joint_len()).map(|words| rows(&floats(words)))
    }
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
