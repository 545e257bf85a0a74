//! Stages of the reconstruction: rotations, gradients, palette, confidence (METHOD §1.1 to §1.7).

use crate::envelope::model::{EnvelopeModel, Factors, Key};
use crate::numeric::affine::{after, linear, seen_from};
use crate::numeric::so3;
use crate::regression::confidence::step;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, SMatrix, Vector3};

impl EnvelopeModel {
    /// Removes the root's motion from J maps: `B_r⁻¹ B_j`, with B_r treated as rigid (METHOD §1.1).
    pub fn relative(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let root = self.skeleton.root();
        let unmoved = |(joint, map): (usize, &Matrix3x4<f64>)| match joint == root {
            true => Matrix3x4::identity(),
            false => seen_from(&pose[root], map),
        };
        pose.iter().enumerate().map(unmoved).collect()
    }

    /// Returns θ_j = log of the rotation nearest to Q_pᵀ Q_j for J relative maps, radians; 0 for the root.
    pub fn rotations(&self, relative: &[Matrix3x4<f64>]) -> Vec<Vector3<f64>> {
        let angle = |(joint, parent): (usize, &Option<usize>)| {
            let Some(parent) = parent else { return Vector3::zeros() };
            let turn = linear(&relative[*parent]).transpose() * linear(&relative[joint]);
            so3::polar(&turn).map_or(Vector3::zeros(), |(rotation, _)| so3::log(&rotation))
        };
        self.skeleton.parents.iter().enumerate().map(angle).collect()
    }

    /// Evaluates the factors of a key's gradient (METHOD §1.4, §1.5).
    pub fn factors(
        &self,
        key: &Key,
        relative: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Factors {
        let above = self.skeleton.parents[key.joint];
        let parent = above.map_or(Matrix3::identity(), |p| linear(&relative[p]));
        key.factors(parent, |joint| &rotations[joint], above)
    }

    /// Predicts the P gradients without the root's motion.
    pub fn gradients(
        &self,
        relative: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        let gradient = |key| self.factors(key, relative, rotations).gradient();
        self.keys().iter().map(gradient).collect()
    }

    /// Evaluates `t = c1 d + c2 q`, then applies the root's map. Returns P maps (METHOD §1.7.3).
    pub fn palette(
        &self,
        root: &Matrix3x4<f64>,
        relative: &[Matrix3x4<f64>],
        gradients: &[Matrix3<f64>],
    ) -> Vec<Matrix3x4<f64>> {
        let Some(reconstruction) = &self.reconstruction else { return Vec::new() };
        let t = &reconstruction.c1 * stack(gradients) + &reconstruction.c2 * stack(relative);
        let map = |l: usize| Matrix3x4::from_fn(|r, c| t[(4 * l + c, r)]);
        (0..reconstruction.keys.len()).map(|l| after(root, &map(l))).collect()
    }

    /// Returns the confidence of a rotational model: the smallest over the joints. A joint has 1 within its trained
    /// range and 0 from 1.5 times the range plus 0.1 rad (FORMAT.md).
    pub fn confidence(&self, rotations: &[Vector3<f64>]) -> f64 {
        let of_joint = |(theta, range): (&Vector3<f64>, &f64)| within(theta.norm(), *range, *range);
        rotations.iter().zip(&self.pose_ranges).map(of_joint).fold(1.0, f64::min)
    }
}

/// Returns 1 up to `max`, then falls to 0 at `max + range / 2 + 0.1` (METHOD §1.8). All angles are in radians.
pub(super) fn within(angle: f64, max: f64, range: f64) -> f64 {
    1.0 - step((angle - max) / (range / 2.0 + 0.1))
}

/// Stacks transposed blocks: row C l + c, column r holds entry r, c of block l.
pub fn stack<const C: usize>(blocks: &[SMatrix<f64, 3, C>]) -> Mat<f64> {
    Mat::from_fn(C * blocks.len(), 3, |row, r| blocks[row / C][(r, row % C)])
}
