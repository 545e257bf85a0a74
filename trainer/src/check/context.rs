//! Data shared by the parts of a check: training frames, LBS residuals, and distances between poses.

use super::finding::{FrameName, Place};
use super::thresholds::{CURVE, SLIDE};
use crate::envelope::correction::features::Features;
use crate::envelope::lbs::poses::{EQUAL, Poses};
use crate::envelope::lbs::training::{Residuals, Training};
use crate::examples::{Clip, Examples};
use crate::space::beside;
use faer::Mat;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// The examples, their training frames, and the LBS residuals.
pub(super) struct Context<'a> {
    pub(super) examples: &'a Examples,
    pub(super) clips: &'a [Clip],
    /// The n training frames.
    pub(super) frames: Vec<usize>,
    pub(super) training: &'a Training<'a>,
    /// LBS residuals in the training frames, 3n x V, in diagonals.
    pub(super) residuals: Mat<f64>,
    /// The joint that each vertex follows most, V.
    pub(super) dominant: Vec<usize>,
    /// Rotations of the joints in the training frames.
    pub(super) turns: Turns,
}

impl<'a> Context<'a> {
    pub(super) fn new(clips: &'a [Clip], training: &'a Training<'a>) -> Self {
        let (residuals, dominant) = training.lbs_residuals();
        Self {
            examples: training.examples,
            clips,
            frames: training.poses.frames(),
            residuals,
            dominant,
            turns: Turns::new(&training.poses, Features::of(training)),
            training,
        }
    }

    /// Converts a length in % of the diagonal to millimetres; `None` if the unit is unknown.
    pub(super) fn mm(&self, percent: f64) -> Option<f64> {
        self.examples.diagonal_mm().map(|diagonal| percent / 100.0 * diagonal)
    }

    /// Formats a length in diagonals for a finding: `0.49 % of the diagonal (4.8 mm)`.
    pub(super) fn length(&self, share: f64) -> String {
        let percent = 100.0 * share;
        format!("{percent:.2} % of the diagonal{}", beside(percent, self.examples.diagonal_mm()))
    }

    pub(super) fn lbs_residuals(&self) -> Residuals<'_> {
        Residuals { training: self.training, residuals: &self.residuals, dominant: &self.dominant }
    }

    /// Names the `i`-th training frame.
    pub(super) fn frame(&self, i: usize) -> FrameName {
        FrameName::new(self.clips, self.frames[i])
    }

    pub(super) fn frames(&self, of: impl IntoIterator<Item = usize>) -> Vec<Place> {
        of.into_iter().map(|i| Place::Frame(self.frame(i))).collect()
    }

    pub(super) fn joint(&self, joint: usize) -> &'a str {
        &self.examples.skeleton.names[joint]
    }

    pub(super) fn joint_place(&self, joint: usize) -> Place {
        Place::Joint(self.joint(joint).to_owned())
    }

    /// Returns the squared LBS residual of a vertex in the `i`-th training frame.
    pub(super) fn squared_error(&self, i: usize, vertex: usize) -> f64 {
        self.residuals.col_as_slice(vertex)[3 * i..3 * i + 3].iter().map(|x| x * x).sum()
    }

    /// Returns the RMS error of LBS over vertices in the `i`-th training frame, in diagonals.
    pub(super) fn rms(&self, i: usize, vertices: &[usize]) -> f64 {
        let sum: f64 = vertices.iter().map(|&v| self.squared_error(i, v)).sum();
        (sum / vertices.len().max(1) as f64).sqrt()
    }

    /// Returns the RMS error of LBS over vertices in all training frames, in diagonals.
    pub(super) fn rms_of(&self, vertices: &[usize]) -> f64 {
        let errors = &self.training.lbs.errors;
        let sum: f64 = vertices.iter().map(|&v| errors[v]).sum();
        (sum / (vertices.len() * self.frames.len()).max(1) as f64).sqrt()
    }
}

/// Sorts indices by a value, the largest first; ties stay in order.
pub(super) fn worst_first(
    indices: impl Iterator<Item = usize>,
    of: impl Fn(usize) -> f64,
) -> Vec<usize> {
    let mut sorted: Vec<(f64, usize)> = indices.map(|index| (of(index), index)).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    sorted.into_iter().map(|(_, index)| index).collect()
}

/// Each joint of each pose, relative to its parent, the identity at rest; and the curves.
pub(super) struct Turns {
    joint_len: usize,
    all: Vec<Turn>,
    /// Curves in degrees, in each pose.
    curves: Vec<Vec<f64>>,
}

/// One joint, relative to its parent.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) rotation: UnitQuaternion<f64>,
    /// Displacement of the origin in the parent's frame, in diagonals.
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
        let curves = |pose: usize| {
            let ranges = poses.curves(pose).iter().zip(poses.curve_ranges());
            ranges.map(|(value, [least, most])| CURVE * value / (most - least).max(EQUAL)).collect()
        };
        Self {
            joint_len,
            all: (0..poses.len() * joint_len).map(of).collect(),
            curves: (0..poses.len()).map(curves).collect(),
        }
    }

    /// Returns the number of poses.
    pub(super) fn len(&self) -> usize {
        self.curves.len()
    }

    pub(super) fn of(&self, pose: usize, joint: usize) -> &Turn {
        &self.all[pose * self.joint_len + joint]
    }

    /// Returns the distance of a joint from rest in a pose, in degrees.
    pub(super) fn bend(&self, pose: usize, joint: usize) -> f64 {
        self.of(pose, joint).gap(&Turn::REST)
    }

    /// Returns the largest distance of a joint from rest, in degrees.
    pub(super) fn largest_bend(&self, joint: usize) -> f64 {
        (0..self.len()).map(|i| self.bend(i, joint)).fold(0.0, f64::max)
    }

    /// Returns the largest distance of a joint from rest without the farthest tenth of the poses, in degrees.
    pub(super) fn usual_bend(&self, joint: usize) -> f64 {
        let mut bends: Vec<f64> = (0..self.len()).map(|i| self.bend(i, joint)).collect();
        bends.sort_by(f64::total_cmp);
        bends.get((9 * bends.len() / 10).min(bends.len().saturating_sub(1))).copied().unwrap_or(0.0)
    }

    /// Returns the largest distance between the joints and curves of two poses, in degrees; infinity beyond `most`.
    pub(super) fn distance(&self, a: usize, b: usize, most: f64) -> f64 {
        let joints = (0..self.joint_len).map(|joint| self.of(a, joint).gap(self.of(b, joint)));
        let curves = self.curves[a].iter().zip(&self.curves[b]).map(|(a, b)| (a - b).abs());
        let mut largest: f64 = 0.0;
        for gap in joints.chain(curves) {
            largest = largest.max(gap);
            if largest > most {
                return f64::INFINITY;
            }
        }
        largest
    }

    /// Returns the distance of a joint from the nearest of the poses, in degrees.
    pub(super) fn nearest(&self, joint: usize, turn: &Turn) -> f64 {
        let gaps = (0..self.len()).map(|i| self.of(i, joint).gap(turn));
        gaps.fold(f64::INFINITY, f64::min)
    }
}

impl Turn {
    /// The rest pose.
    const REST: Self = Self {
        rotation: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        slide: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Returns the distance in degrees: the angle, or the slide if that weighs more.
    pub(super) fn gap(&self, other: &Self) -> f64 {
        let angle = self.rotation.angle_to(&other.rotation).to_degrees();
        angle.max(SLIDE * (self.slide - other.slide).norm())
    }
}
