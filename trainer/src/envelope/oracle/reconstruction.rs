//! Stages of the reconstruction: rotations, gradients, palette, confidence (METHOD §1.1 to §1.7).

use crate::envelope::model::{EnvelopeModel, Factors, Key};
use crate::numeric::affine::{Strain, after, linear};
use crate::numeric::so3;
use crate::regression::confidence::step;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, SMatrix, Vector3};

impl EnvelopeModel {
    /// Removes the root's motion from J maps: `B_r⁻¹ B_j`, with B_r treated as rigid if no joint stretches (METHOD
    /// §1.1). Below a hidden root the maps are 0.
    pub fn relative(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let root = self.skeleton.root();
        let inverse = match self.stretch_ranges {
            Some(_) if self.turns(pose)[root].is_none() => Matrix3::zeros(),
            Some(_) => linear(&pose[root]).try_inverse().unwrap_or_default(),
            None => linear(&pose[root]).transpose(),
        };
        let unmoved = |(joint, map): (usize, &Matrix3x4<f64>)| {
            if joint == root {
                return Matrix3x4::identity();
            }
            let mut apart = *map;
            apart.column_mut(3).axpy(-1.0, &pose[root].column(3), 1.0);
            inverse * apart
        };
        pose.iter().enumerate().map(unmoved).collect()
    }

    /// Returns θ_j = log of the rotation nearest to R_pᵀ R_j for J maps, radians; 0 for the root.
    pub fn rotations(&self, pose: &[Matrix3x4<f64>]) -> Vec<Vector3<f64>> {
        let turns = self.turns(pose);
        let angle = |(joint, parent): (usize, &Option<usize>)| {
            let parent = (*parent)?;
            let turn = turns[parent]?.transpose() * turns[joint]?;
            so3::polar(&turn).map(|(rotation, _)| so3::log(&rotation))
        };
        self.skeleton.parents.iter().enumerate().map(|at| angle(at).unwrap_or_default()).collect()
    }

    /// Evaluates the factors of a key's gradient (METHOD §1.4, §1.5).
    pub fn factors(
        &self,
        key: &Key,
        pose: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Factors {
        let above = self.skeleton.parents[key.joint];
        let turns = self.turns(pose);
        let turn = |joint: usize| turns[joint].unwrap_or_default();
        let root = turn(self.skeleton.root()).transpose();
        let parent = above.map_or(Matrix3::identity(), |p| root * turn(p));
        let strain = match self.stretch_ranges {
            Some(_) => self.strains(pose)[key.joint],
            None => Strain::default(),
        };
        key.factors(parent, |joint| &rotations[joint], above, &strain)
    }

    /// Predicts the P gradients without the root's motion.
    ///
    /// - `pose`: skinning matrices, J.
    pub fn gradients(
        &self,
        pose: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        let gradient = |key| self.factors(key, pose, rotations).gradient();
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
    pub fn confidence(&self, pose: &[Matrix3x4<f64>], rotations: &[Vector3<f64>]) -> f64 {
        let of_joint = |(theta, range): (&Vector3<f64>, &f64)| within(theta.norm(), *range, *range);
        let angles = rotations.iter().zip(&self.pose_ranges).map(of_joint);
        angles.chain(self.stretch_confidences(pose)).fold(1.0, f64::min)
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
