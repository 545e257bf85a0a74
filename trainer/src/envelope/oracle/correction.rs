//! The stages of the correction (METHOD §1.9).

use super::reconstruction::within;
use crate::envelope::model::{EnvelopeModel, Group};
use crate::numeric::affine::{linear, seen_from};
use crate::numeric::so3;
use crate::regression::confidence::ExpectedError;
use crate::regression::map::Value;
use nalgebra::{Matrix3x4, Vector3};

impl EnvelopeModel {
    /// Returns the base of the kernel predictor's palette: the J joints, then for each helper its
    /// dominant joint.
    pub fn joints(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let base = |group: &Group| std::iter::repeat_n(pose[group.joint], group.proxies.len());
        pose.iter().copied().chain(self.groups.iter().flat_map(base)).collect()
    }

    /// Returns J features: of a joint that its parent sees move by `M = [R | t]`, rows of
    /// `[half of R | M o - o]`, o its origin, as [`so3::half`] has it; 0 for the root.
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

    /// Adds `Q_dom K` to the palette's last P maps; returns them all, and the confidence: the least of what groups and
    /// ranges know, 1 without groups.
    pub fn correct(
        &self,
        pose: &[Matrix3x4<f64>],
        features: &[Matrix3x4<f64>],
        mut palette: Vec<Matrix3x4<f64>>,
    ) -> (Vec<Matrix3x4<f64>>, f64) {
        let first = self.first_proxy();
        let mut known = ExpectedError::default();
        for group in self.groups.iter().filter(|group| group.has_centres()) {
            let Value { outputs, expected_error } = group.map.evaluate(&group.input(features));
            let proxies = &mut palette[first..][group.proxies.clone()];
            let share = expected_error.map_weight();
            for (out, map) in proxies.iter_mut().zip(group.maps(&outputs)) {
                *out += linear(&pose[group.joint]) * map * share;
            }
            known = known.plus(expected_error);
        }
        let own = self.known_of_joints(features).into_iter();
        (palette, own.fold(known.confidence(), f64::min))
    }

    /// Returns what is known of each joint's angle: 1 up to one and a half times its range, none of an envelope without
    /// groups. 4 sin(angle / 4) stands for the angle.
    pub fn known_of_joints(&self, features: &[Matrix3x4<f64>]) -> Vec<f64> {
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
