//! The arrays of a pose, and their check.

use crate::error::{Argument, CallError};
use crate::linear::Matrix3x4;

/// What moves a skin: J skinning matrices and C curves, or those of several poses.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub(crate) joints: &'a [Matrix3x4],
    pub(crate) curves: &'a [f32],
}

impl<'a> Pose<'a> {
    /// Splits off the first pose: J matrices and C curves.
    pub(crate) fn split(self, joint_len: usize, curve_len: usize) -> (Self, Self) {
        let (joints, other_joints) = self.joints.split_at(joint_len.min(self.joints.len()));
        let (curves, other_curves) = self.curves.split_at(curve_len.min(self.curves.len()));
        (Self { joints, curves }, Self { joints: other_joints, curves: other_curves })
    }

    /// Checks that all matrices and curves are finite.
    pub(crate) fn check_finite(self) -> Result<(), CallError> {
        Argument::Pose.check_finite(self.joints.iter().position(|m| !is_finite(m)))?;
        Argument::Curves.check_finite(self.curves.iter().position(|value| !value.is_finite()))
    }
}

/// Whether every entry of a matrix is finite.
#[inline]
pub(super) fn is_finite(m: &Matrix3x4) -> bool {
    m.as_flattened().iter().all(|x| x.is_finite())
}
