//! How far poses are from each other, joint by joint, in degrees.

use super::thresholds::SLIDE;
use crate::envelope::correction::features::Features;
use crate::envelope::lbs::poses::Poses;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// Each joint of each pose against its parent, at rest the identity.
pub(super) struct Turns {
    joint_len: usize,
    all: Vec<Turn>,
}

/// One joint against its parent.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) rotation: UnitQuaternion<f64>,
    /// How far its origin moves in the parent's frame, in diagonals.
    pub(super) slide: Vector3<f64>,
}

impl Turns {
    pub(super) fn new(poses: &Poses, joints: Features<'_>) -> Self {
        let joint_len = poses.joint_len();
        let of = |at: usize| {
            let (rotation, slide) = joints.relative(poses, at / joint_len, at % joint_len);
            let rotation = Rotation3::from_matrix_unchecked(rotation);
            Turn { rotation: UnitQuaternion::from_rotation_matrix(&rotation), slide }
        };
        Self { joint_len, all: (0..poses.len() * joint_len).map(of).collect() }
    }

    /// Returns how many poses there are.
    pub(super) fn len(&self) -> usize {
        self.all.len() / self.joint_len
    }

    pub(super) fn of(&self, pose: usize, joint: usize) -> &Turn {
        &self.all[pose * self.joint_len + joint]
    }

    /// How far the joint is from rest in a pose.
    pub(super) fn bend(&self, pose: usize, joint: usize) -> f64 {
        self.of(pose, joint).gap(&Turn::REST)
    }

    /// How far the joint is from rest where it is farthest.
    pub(super) fn farthest(&self, joint: usize) -> f64 {
        (0..self.len()).map(|i| self.bend(i, joint)).fold(0.0, f64::max)
    }

    /// How far the joint is from rest at most, the farthest tenth of the poses left out.
    pub(super) fn usual(&self, joint: usize) -> f64 {
        let mut bends: Vec<f64> = (0..self.len()).map(|i| self.bend(i, joint)).collect();
        bends.sort_by(f64::total_cmp);
        bends.get((9 * bends.len() / 10).min(bends.len().saturating_sub(1))).copied().unwrap_or(0.0)
    }

    /// How far the joints of two poses are apart where they are farthest; infinite beyond `most`.
    pub(super) fn apart(&self, a: usize, b: usize, most: f64) -> f64 {
        let mut apart: f64 = 0.0;
        for joint in 0..self.joint_len {
            apart = apart.max(self.of(a, joint).gap(self.of(b, joint)));
            if apart > most {
                return f64::INFINITY;
            }
        }
        apart
    }

    /// How far a joint is from the nearest of these poses.
    pub(super) fn nearest(&self, joint: usize, turn: &Turn) -> f64 {
        let gaps = (0..self.len()).map(|i| self.of(i, joint).gap(turn));
        gaps.fold(f64::INFINITY, f64::min)
    }
}

impl Turn {
    /// At rest.
    const REST: Self = Self {
        rotation: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        slide: Vector3::new(0.0, 0.0, 0.0),
    };

    /// How far two are apart, in degrees: by angle or by slide, whichever is more.
    pub(super) fn gap(&self, other: &Self) -> f64 {
        let angle = self.rotation.angle_to(&other.rotation).to_degrees();
        angle.max(SLIDE * (self.slide - other.slide).norm())
    }
}
