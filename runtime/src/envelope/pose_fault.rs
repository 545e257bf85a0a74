//! What a pose has wrong, and what to do about it.

use core::fmt;

/// Why a pose is none of the skeleton's: what [`crate::Envelope::check_pose`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseFault {
    /// The likely mistake.
    pub kind: PoseFaultKind,
    /// The joint that shows it; of [`PoseFaultKind::Length`] the number of matrices that were given.
    pub joint: usize,
    /// Of a scale how large it is; of units what to multiply the pose's lengths by, 1 where they are right.
    pub factor: f32,
    /// How far the joint is from what it may be: off a rotation, or off the place to which its parent carries it.
    pub found: f32,
    /// How far it may be.
    pub allowed: f32,
    /// Which axis of the pose each axis of the model is, from 1 and negative where it is turned round.
    pub axes: [i8; 3],
}

/// The mistake of a [`PoseFault`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum PoseFaultKind {
    /// The pose has not one matrix a joint.
    Length = 1,
    /// A matrix is not finite.
    NonFinite = 2,
    /// A matrix mirrors.
    Mirrored = 3,
    /// A matrix scales by [`PoseFault::factor`] along all axes.
    Scaled = 4,
    /// A matrix scales along axes by different factors, or shears.
    Stretched = 5,
    /// The matrices' rotations are transposed, and their translations may be lost.
    Transposed = 6,
    /// Lengths are in another unit: [`PoseFault::factor`] of them make one of the model's.
    Units = 7,
    /// The pose is in other axes of the same handedness, [`PoseFault::axes`].
    Axes = 8,
    /// The pose is in axes of the other handedness, [`PoseFault::axes`].
    Handedness = 9,
    /// A joint is off the place to which its parent carries it, and no mistake about the whole pose explains it.
    Apart = 10,
    /// No frame was written: a matrix is zero, or all gathered frames are the identity.
    Unset = 11,
    /// The matrices are the joints' frames: the inverse bind matrices were not applied.
    Frames = 12,
    /// The inverse bind matrices were applied twice.
    BoundTwice = 13,
    /// Each matrix, or each gathered frame, is in the space of the joint's parent.
    Local = 14,
}

impl PoseFault {
    /// Makes a fault of a joint, in the model's own axes and unit.
    pub(super) const fn new(kind: PoseFaultKind, joint: usize) -> Self {
        Self { kind, joint, factor: 1.0, found: 0.0, allowed: 0.0, axes: [1, 2, 3] }
    }
}

impl PoseFaultKind {
    /// Every kind.
    pub const ALL: [Self; 14] = [
        Self::Length,
        Self::NonFinite,
        Self::Mirrored,
        Self::Scaled,
        Self::Stretched,
        Self::Transposed,
        Self::Units,
        Self::Axes,
        Self::Handedness,
        Self::Apart,
        Self::Unset,
        Self::Frames,
        Self::BoundTwice,
        Self::Local,
    ];

    /// Returns what to do about it.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Length => "give one matrix a joint, in the order of the file's joints",
            Self::NonFinite => "look where the joint's matrix comes from",
            Self::Mirrored => "take the mirror out of the actor and put it on the palette",
            Self::Scaled => {
                "take a scale that all joints share out with take_scale and put it on the palette; joints scaled by \
                 themselves are not part of the model"
            }
            Self::Stretched => "joints only turn and move: drop scale and shear from the joint",
            Self::Transposed => "read the matrices with matrix::from_columns",
            Self::Units => "convert the pose, or bake the model in your unit with --to-unit",
            Self::Axes => {
                "convert the pose, or bake the model in your axes with --to-up and --to-forward"
            }
            Self::Handedness => {
                "convert the pose, or bake the model in your axes with --to-hand, --to-up and --to-forward"
            }
            Self::Apart => {
                "look whether the joint has this parent and this inverse bind matrix, or train with poses that move \
                 it so far"
            }
            Self::Unset => "write the skeleton's frames before the pose is made of them",
            Self::Frames => {
                "multiply each frame by the joint's inverse bind matrix, as gather_pose does"
            }
            Self::BoundTwice => "give gather_pose the joints' frames, not skinning matrices",
            Self::Local => {
                "chain the local transforms with model_space_pose, or take frames after the hierarchy pass"
            }
        }
    }
}

impl core::error::Error for PoseFault {}

impl fmt::Display for PoseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, joint, factor, found, allowed, axes: [x, y, z] } = *self;
        match kind {
            PoseFaultKind::Length => write!(f, "pose: {joint} matrices are not one a joint")?,
            PoseFaultKind::NonFinite => write!(f, "pose: joint {joint} is not finite")?,
            PoseFaultKind::Mirrored => write!(f, "pose: joint {joint} is mirrored")?,
            PoseFaultKind::Scaled => write!(f, "pose: joint {joint} is scaled by {factor}")?,
            PoseFaultKind::Stretched => write!(
                f,
                "pose: joint {joint} is scaled unevenly or sheared, off a rotation by {found}, expected at most \
                 {allowed}"
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
