//! Stages of the correction: joints, features, correction (METHOD §1.9).

use super::reconstruction::within;
use crate::envelope::model::{EnvelopeModel, Group};
use crate::numeric::affine::{linear, seen_from};
use crate::numeric::so3;
use crate::regression::confidence::ExpectedError;
use crate::regression::map::Value;
use nalgebra::{Matrix3x4, Vector3};

impl EnvelopeModel {
    /// Returns the base palette of the kernel predictor: the J joints, then the dominant joint of each helper.
    pub fn joints(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let base = |group: &Group| std::iter::repeat_n(pose[group.joint], group.proxies.len());
        pose.iter().copied().chain(self.groups.iter().flat_map(base)).collect()
    }

    /// Returns J features, 0 for the root. A joint that moves by `M = [R | t]` in the frame of its parent has the
    /// feature `[half of R | M o - o]`; o is its origin, and [`so3::half`] defines half of R.
    pub fn features(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let of_joint = |(joint, parent): (usize, &Option<usize>)| {
            parent.map_or(Matrix3x4::zeros(), |parent| {
                let origin = self.origin(joint);
                let mut apart = seen_from(&pose[parent], &pose[joint]);
                let moved = apart * origin.push(1.0) - origin;
                let turn = so3::half(&linear(&apart));
                apart.fixed_columns_mut::<3>(0).copy_from(&turn);
                apart.set_column(3, &moved);
                apart
            })
        };
        self.skeleton.parents.iter().enumerate().map(of_joint).collect()
    }

    /// Adds `Q_dom K` to the palette's last P maps. Returns the palette and the confidence: the smallest confidence of
    /// all groups and joints, or 1 without groups.
    pub fn correct(
        &self,
        pose: &[Matrix3x4<f64>],
        features: &[Matrix3x4<f64>],
        mut palette: Vec<Matrix3x4<f64>>,
    ) -> (Vec<Matrix3x4<f64>>, f64) {
        let first = self.first_proxy();
        let mut total = ExpectedError::default();
        for group in self.groups.iter().filter(|group| group.has_centres()) {
            let Value { outputs, expected_error } = group.map.evaluate(&group.input(features));
            let proxies = &mut palette[first..][group.proxies.clone()];
            let share = expected_error.map_weight();
            for (out, map) in proxies.iter_mut().zip(group.maps(&outputs)) {
                *out += linear(&pose[group.joint]) * map * share;
            }
            total = total.plus(expected_error);
        }
        let of_joints = self.joint_confidences(features).into_iter();
        (palette, of_joints.fold(total.confidence(), f64::min))
    }

    /// Returns the confidence of each joint, J: 1 up to 1.5 times its trained range, then falling to 0. Empty for an
    /// envelope without groups. The angle is approximated by 4 sin(angle / 4).
    pub fn joint_confidences(&self, features: &[Matrix3x4<f64>]) -> Vec<f64> {
        if self.groups.is_empty() {
            return Vec::new();
        }
        let of_joint = |(feature, range): (&Matrix3x4<f64>, &f64)| {
            let angle = 2.0 * (-linear(feature).trace()).max(0.0).sqrt();
            within(angle, 1.5 * range, *range)
        };
        features.iter().zip(&self.pose_ranges).map(of_joint).collect()
    }

    /// Returns a joint's rest origin.
    pub fn origin(&self, joint: usize) -> Vector3<f64> {
        self.skeleton.rest[joint].map(|row| row[3]).into()
    }
}
