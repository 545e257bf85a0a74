//! Faults of a pose: the tolerances, the likely mistakes, and how to fix each.

use crate::envelope::view::Envelope;
use crate::linear::{Matrix3x4, inverse};
use crate::named::named;
use core::fmt;

/// Allowed difference between the products of a matrix's rows and the products of a rotation's rows: a scale of 1.001.
pub const RIGID_TOLERANCE: f32 = 2.0e-3;
/// Allowed gap between a joint and its parent, in multiples of the joint's largest gap in training.
pub const GAP_MARGIN: f32 = 2.0;
/// Gap allowed at any joint, as a share of the diagonal: more than rounding, and less than one sees.
pub const GAP_TOLERANCE: f32 = 1.0e-3;

/// Allowed strain of a joint that stretches, in multiples of its largest strain in training.
pub const STRETCH_MARGIN: f32 = 2.0;
/// Allowed size of a curve, in multiples of its largest size in training.
pub const CURVE_MARGIN: f32 = 10.0;

/// Reason why a pose does not fit the skeleton, from [`crate::Envelope::check_pose`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct PoseFault {
    /// The likely mistake.
    pub kind: PoseFaultKind,
    /// First joint or curve that shows the mistake; for [`PoseFaultKind::Length`] and [`PoseFaultKind::CurveLength`]
    /// the number of matrices or curves found.
    pub joint: usize,
    /// Scale of the matrix, or the factor that converts lengths of the pose to the model's unit; else 1.
    pub factor: f32,
    /// Deviation of the joint: from a rotation, or from where the joint's parent carries the joint.
    pub found: f32,
    /// Largest deviation that is allowed.
    pub allowed: f32,
    /// Axis of the pose for each axis of the model, from 1; negative if the axis points the other way.
    pub axes: [i8; 3],
}

named! {
    /// Mistake of a [`PoseFault`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum PoseFaultKind {
        /// The number of matrices differs from the number of joints.
        Length = 1, "give one matrix for each joint, in the order of the file's joints";
        /// A matrix is not finite.
        NonFinite = 2, "look where the joint's matrix comes from";
        /// A matrix mirrors.
        Mirrored = 3, "take the mirror out of the actor and put it on the palette";
        /// A matrix scales by [`PoseFault::factor`] along all axes.
        Scaled = 4,
            "take a scale that all joints share out with take_scale and put it on the palette; drop the scale of a \
            single joint, or train with poses that scale it";
        /// A matrix scales unevenly, or shears, further than in training.
        Stretched = 5,
            "drop scale and shear from the joint, or train with poses that stretch it so far";
        /// The rotations are transposed, and the translations may be lost.
        Transposed = 6, "read the matrices with matrix::from_columns";
        /// Lengths are in another unit: multiply lengths by [`PoseFault::factor`] to get the model's unit.
        Units = 7, "convert the pose, or bake the model in your unit with --to-unit";
        /// The pose has other axes of the same handedness, [`PoseFault::axes`].
        Axes = 8, "convert the pose, or bake the model in your axes with --to-up and --to-forward";
        /// The pose has axes of the other handedness, [`PoseFault::axes`].
        Handedness = 9,
            "convert the pose, or bake the model in your axes with --to-hand, --to-up and --to-forward";
        /// A joint is not where its parent carries it, and no mistake about the whole pose explains the gap.
        Apart = 10,
            "look whether the joint has this parent and this inverse bind matrix, or train with poses that move \
            it so far";
        /// No frame was written: a matrix is zero, or all gathered frames are the identity.
        Unset = 11, "write the skeleton's frames before the pose is made of them";
        /// The matrices are the joints' frames: the inverse bind matrices were not applied.
        Frames = 12, "multiply each frame by the joint's inverse bind matrix, as gather_pose does";
        /// The inverse bind matrices were applied twice.
        BoundTwice = 13, "give gather_pose the joints' frames, not skinning matrices";
        /// Each matrix, or each gathered frame, is in the space of the joint's parent.
        Local = 14,
            "chain the local transforms with model_space_pose, or take frames after the hierarchy pass";
        /// A matrix is scaled to 0, as engines hide limbs. The palette treats the joint as at rest.
        Hidden = 15, "show the joint, or leave the check out for poses that hide joints";
        /// The number of curves differs from the file's.
        CurveLength = 16, "give one value for each curve, in the order of the file's curves";
        /// A curve is not finite, or far beyond its values in training.
        Curve = 17, "give the curve in the unit of training: a percentage must be divided by 100";
    }
    /// Every kind.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) ALL;
    /// Returns how to fix the mistake.
    pub remedy;
}

impl PoseFault {
    /// Makes a fault of a joint, in the model's axes and unit.
    pub(super) const fn new(kind: PoseFaultKind, joint: usize) -> Self {
        Self { kind, joint, factor: 1.0, found: 0.0, allowed: 0.0, axes: [1, 2, 3] }
    }
}

impl core::error::Error for PoseFault {}

impl fmt::Display for PoseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, joint, factor, found, allowed, axes: [x, y, z] } = *self;
        match kind {
            PoseFaultKind::Length => {
                write!(f, "pose: {joint} matrices are not one for each joint")?
            }
            PoseFaultKind::NonFinite => write!(f, "pose: joint {joint} is not finite")?,
            PoseFaultKind::Mirrored => write!(f, "pose: joint {joint} is mirrored")?,
            PoseFaultKind::Scaled => write!(f, "pose: joint {joint} is scaled by {factor}")?,
            PoseFaultKind::Stretched => write!(
                f,
                "pose: joint {joint} is scaled unevenly or sheared, off a rotation by {found}, expected at most \
                 {allowed}"
            )?,
            PoseFaultKind::Hidden => {
                write!(f, "pose: joint {joint} is hidden: scaled to {factor}")?
            }
            PoseFaultKind::CurveLength => {
                write!(f, "pose: {joint} curves are not one for each curve of the file")?
            }
            PoseFaultKind::Curve => write!(
                f,
                "pose: curve {joint} is {found}, expected at most {allowed} in either direction"
            )?,
            PoseFaultKind::Transposed => {
                write!(
                    f,
                    "pose: matrices are transposed, joint {joint} is off its parent by {found}"
                )?;
            }
            PoseFaultKind::Units => write!(
                f,
                "pose: lengths are in another unit and must be multiplied by {factor}, joint {joint} is off its \
                 parent by {found}"
            )?,
            PoseFaultKind::Axes | PoseFaultKind::Handedness => {
                let other = if kind == PoseFaultKind::Axes {
                    "in other axes"
                } else {
                    "of the other handedness"
                };
                write!(
                    f,
                    "pose: matrices are {other}, the model's x, y, z are axes {x}, {y}, {z} of theirs and lengths \
                     times {factor}, joint {joint} is off its parent by {found}"
                )?;
            }
            PoseFaultKind::Apart => write!(
                f,
                "pose: joint {joint} is off its parent by {found}, expected at most {allowed}"
            )?,
            PoseFaultKind::Unset => write!(
                f,
                "pose: joint {joint} was not set: its matrix is zero, or every frame is the identity"
            )?,
            PoseFaultKind::Frames => write!(
                f,
                "pose: the matrices are the joints' frames, without the inverse bind matrices, joint {joint} is off \
                 its parent by {found}"
            )?,
            PoseFaultKind::BoundTwice => write!(
                f,
                "pose: the inverse bind matrices are applied twice, joint {joint} is off its parent by {found}"
            )?,
            PoseFaultKind::Local => write!(
                f,
                "pose: each matrix is in the space of the joint's parent, joint {joint} is off its parent by {found}"
            )?,
        }
        write!(f, ": {}", kind.remedy())
    }
}

/// Returns the gap allowed between a joint and its parent, without the rounding of its position.
///
/// - `diagonal`: of the rest pose's box.
/// - `gap`: the joint's largest gap in training.
#[inline]
pub(super) fn allowance(diagonal: f32, gap: f32) -> f32 {
    GAP_TOLERANCE * diagonal + GAP_MARGIN * gap
}

/// Returns the [`allowance`] of a joint of an envelope.
pub(super) fn allowance_of(envelope: &Envelope<'_>, joint: usize) -> f32 {
    allowance(envelope.certificate().diagonal, envelope.pose_gap(joint).unwrap_or_default())
}

/// Returns the rest origin of a joint in model space, from the joint's inverse bind matrix.
#[inline]
pub(super) fn rest_origin(bind: &Matrix3x4) -> [f32; 3] {
    inverse(bind).map(|[.., shift]| shift)
}
