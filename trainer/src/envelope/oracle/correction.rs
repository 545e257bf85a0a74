//! Stages of the correction: joints, features, correction (METHOD §1.9).

use super::Pose;
use super::reconstruction::within;
use crate::envelope::model::{Curve, EnvelopeModel, Group};
use crate::numeric::affine::{Strain, linear, strain, strain_norm};
use crate::numeric::so3;
use crate::numeric::trs::project;
use crate::regression::confidence::ExpectedError;
use crate::regression::map::Value;
use nalgebra::{Matrix3, Matrix3x4, Vector3};

/// Determinant below which a joint counts as scaled to 0 or mirrored (FORMAT.md).
const HIDDEN: f64 = 1e-3;

impl EnvelopeModel {
    /// Returns the base palette of the kernel predictor: the J joints, then the dominant joint of each helper.
    pub fn joints(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let base =
            |group: &Group| std::iter::repeat_n(dominant(pose, group.joint), group.proxies.len());
        pose.iter().copied().chain(self.groups.iter().flat_map(base)).collect()
    }

    /// Returns the rotation of each joint, J: the nearest one for a joint that stretches, and the linear part for
    /// others. A joint that is scaled to 0 or mirrored has `None`.
    pub fn turns(&self, pose: &[Matrix3x4<f64>]) -> Vec<Option<Matrix3<f64>>> {
        let stretches =
            |joint: usize| self.stretch_ranges.as_ref().is_some_and(|ranges| ranges[joint] > 0.0);
        let turn = |(joint, map): (usize, &Matrix3x4<f64>)| {
            let linear = linear(map);
            let nearest = || so3::polar(&linear).map_or(linear, |(turn, _)| turn);
            let turn = if stretches(joint) { nearest() } else { linear };
            (linear.determinant() >= HIDDEN).then_some(turn)
        };
        pose.iter().enumerate().map(turn).collect()
    }

    /// Returns the strain of each joint, J; 0 for a joint that is scaled to 0 or mirrored.
    pub fn strains(&self, pose: &[Matrix3x4<f64>]) -> Vec<Strain> {
        let of = |map: &Matrix3x4<f64>| {
            let linear = linear(map);
            if linear.determinant() >= HIDDEN { strain(&linear) } else { Strain::default() }
        };
        pose.iter().map(of).collect()
    }

    /// Returns the features of a pose, in the order of a file.
    ///
    /// Joint j with parent p has `[half of R_pᵀ R_j | R_pᵀ (B_j - B_p) o]`; o is its origin, and [`so3::half`] defines
    /// half of a rotation. The root has 0.
    pub fn features(&self, pose: Pose<'_>) -> Vec<f64> {
        let turns = self.turns(pose.joints);
        let of_joint = |(joint, parent): (usize, &Option<usize>)| {
            let mut feature = Matrix3x4::zeros();
            if let Some(parent) = *parent
                && let (Some(own), Some(above)) = (turns[joint], turns[parent])
            {
                let gap = (pose.joints[joint] - pose.joints[parent]) * self.origin(joint).push(1.0);
                let half = so3::half(&(above.transpose() * own));
                feature.fixed_columns_mut::<3>(0).copy_from(&half);
                feature.set_column(3, &(above.transpose() * gap));
            }
            feature.transpose().as_slice().to_vec()
        };
        let joints = self.skeleton.parents.iter().enumerate().flat_map(of_joint);
        let strains = match self.stretch_ranges {
            Some(_) => self.strains(pose.joints),
            None => Vec::new(),
        };
        joints.chain(strains.into_flattened()).chain(pose.curves.iter().copied()).collect()
    }

    /// Adds `A_dom K` to the palette's last P maps, and projects them onto the kind of the helpers. Returns the palette and the confidence: the smallest confidence of
    /// all groups, joints and curves, or 1 without groups.
    pub fn correct(
        &self,
        pose: &[Matrix3x4<f64>],
        features: &[f64],
        mut palette: Vec<Matrix3x4<f64>>,
    ) -> (Vec<Matrix3x4<f64>>, f64) {
        let first = self.first_proxy();
        let order = self.feature_order();
        let mut total = ExpectedError::default();
        for group in self.groups.iter().filter(|group| group.has_centres()) {
            let input = group.input(features, order);
            let Value { outputs, expected_error } = group.map.evaluate(&input);
            let proxies = &mut palette[first..][group.proxies.clone()];
            let share = expected_error.map_weight();
            for (out, map) in proxies.iter_mut().zip(group.maps(&outputs)) {
                *out += linear(&dominant(pose, group.joint)) * map * share;
            }
            total = total.plus(expected_error);
        }
        for (map, place) in palette[first..].iter_mut().zip(&self.places) {
            *map = project(self.helper_kind, map, &place.centre);
        }
        let of_joints = self.joint_confidences(pose, features).into_iter();
        (
            palette,
            of_joints.chain(self.curve_confidences(features)).fold(total.confidence(), f64::min),
        )
    }

    /// Returns the confidence of each joint, J: 1 up to 1.5 times its trained ranges, then falling to 0. Empty for an
    /// envelope without groups. The angle is approximated by 4 sin(angle / 4).
    pub fn joint_confidences(&self, pose: &[Matrix3x4<f64>], features: &[f64]) -> Vec<f64> {
        if self.groups.is_empty() {
            return Vec::new();
        }
        let of_angle = |(feature, range): (&[f64], &f64)| {
            let angle = 2.0 * (-feature[0] - feature[5] - feature[10]).max(0.0).sqrt();
            within(angle, 1.5 * range, *range)
        };
        let angles = features.chunks(12).zip(&self.pose_ranges).map(of_angle);
        let others = self.stretch_confidences(pose);
        angles.zip(others).map(|(angle, other)| angle.min(other)).collect()
    }

    /// Returns the confidence of each joint from its strain, J; 0 for a joint that is scaled to 0 or mirrored.
    pub fn stretch_confidences(&self, pose: &[Matrix3x4<f64>]) -> Vec<f64> {
        let strains = self.strains(pose);
        let of = |(joint, turn): (usize, &Option<Matrix3<f64>>)| match (turn, &self.stretch_ranges)
        {
            (None, _) => 0.0,
            (Some(_), None) => 1.0,
            (Some(_), Some(ranges)) => {
                within(strain_norm(&strains[joint]), 1.5 * ranges[joint], ranges[joint])
            }
        };
        self.turns(pose).iter().enumerate().map(of).collect()
    }

    /// Returns the confidence of each curve, C.
    pub fn curve_confidences(&self, features: &[f64]) -> Vec<f64> {
        let values = features.iter().rev().take(self.curves.len()).rev();
        let of = |(value, curve): (&f64, &Curve)| {
            let [least, most] = curve.range;
            let half = (most - least) / 2.0;
            within((value - least - half).abs(), 1.5 * half, half)
        };
        values.zip(&self.curves).map(of).collect()
    }

    /// Returns a joint's rest origin.
    pub fn origin(&self, joint: usize) -> Vector3<f64> {
        self.skeleton.rest[joint].map(|row| row[3]).into()
    }
}

/// Returns the transform of a group's dominant joint; the identity without joints.
fn dominant(pose: &[Matrix3x4<f64>], joint: usize) -> Matrix3x4<f64> {
    pose.get(joint).copied().unwrap_or(Matrix3x4::identity())
}
