//! What LBS leaves of the training frames, by the joints that the vertices follow.

use super::training::Training;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// What LBS leaves of the training frames.
#[derive(Clone, Copy)]
pub struct Residuals<'a> {
    /// The training frames.
    pub training: &'a Training<'a>,
    /// What it leaves, 3n x V, in diagonals.
    pub left: &'a Mat<f64>,
    /// The joint that each vertex follows most, V.
    pub dominant: &'a [usize],
}

impl Residuals<'_> {
    /// Lists the vertices that follow each joint most, J lists.
    pub fn skins(&self) -> Vec<Vec<usize>> {
        let mut skins = vec![Vec::new(); self.training.poses.joint_len()];
        for (vertex, &joint) in self.dominant.iter().enumerate() {
            skins[joint].push(vertex);
        }
        skins
    }

    /// Computes the inner products of some poses' residuals of a joint's skin, in the joint's own frame and as the
    /// vertices count.
    pub fn gram(&self, joint: usize, skin: &[usize], poses: &[usize]) -> Mat<f64> {
        let mut left = Mat::zeros(3 * skin.len(), poses.len());
        for (i, &pose) in poses.iter().enumerate() {
            let turn: Matrix3<f64> =
                self.training.poses.map(pose, joint).fixed_columns::<3>(0).transpose();
            for (k, &vertex) in skin.iter().enumerate() {
                let counts = self.training.importance().of(vertex).sqrt();
                let column = self.left.col_as_slice(vertex);
                let own = turn * Vector3::from_column_slice(&column[3 * pose..3 * pose + 3]);
                (0..3).for_each(|axis| left[(3 * k + axis, i)] = counts * own[axis]);
            }
        }
        left.transpose() * &left
    }
}
