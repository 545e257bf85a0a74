//! Refinement of c1 and c2 on the training meshes.
//!
//! The Poisson reconstruction trusts the predicted gradients; where the prediction errs in a way
//! that repeats, the training meshes show it. The correction Δ of `[c1 c2]` is a ridge regression
//! of what the reduced reconstruction leaves over on the gradients and joints themselves, so the
//! evaluation keeps its form and its cost. It acts on `d - I` and `q - rest`, and the root's block
//! of c2, which multiplies a constant, takes up what that subtracts: the rest pose stays exact.

use super::reduce::Reduced;
use crate::envelope::skin::poses::Poses;
use crate::envelope::skin::stacked::in_poses;
use crate::numeric::ridge::solve_ridge;
use faer::Mat;

/// The regression of a palette's residual on the deviations of its inputs from rest.
#[derive(Clone)]
pub struct Regression {
    gram: Mat<f64>,
    right: Mat<f64>,
    rows: f64,
    keys: usize,
    root: usize,
}

impl Regression {
    /// Sums over the poses that are not left out: gradients (3n x 3P), residual maps (3n x 4P).
    pub fn new(
        gradients: &Mat<f64>,
        poses: &Poses,
        residual: &Mat<f64>,
        left_out: &[usize],
    ) -> Self {
        let all = features(gradients, poses);
        let (mut gram, mut right) = (all.transpose() * &all, all.transpose() * residual);
        let [x, r] = [&all, residual].map(|all| in_poses(all, left_out));
        gram -= x.transpose() * &x;
        right -= x.transpose() * &r;
        let rows = (all.nrows() - x.nrows()) as f64;
        Self { gram, right, rows, keys: gradients.ncols(), root: poses.root() }
    }

    /// Adds the sums of other poses, which count differently.
    #[must_use]
    pub fn and(&self, others: &Self, count: f64) -> Self {
        Self {
            gram: &self.gram + &others.gram * faer::Scale(count),
            right: &self.right + &others.right * faer::Scale(count),
            rows: self.rows + others.rows * count,
            ..*self
        }
    }

    /// Adds Δ at a ridge of `strength` an equation to c1 and c2.
    pub fn refine(&self, reduced: &Reduced, strength: f64) -> Reduced {
        let ridge = strength * self.rows;
        let delta = solve_ridge(&mut self.gram.clone(), self.right.clone(), ridge);
        let mut refined = reduced.clone();
        for row in 0..refined.c1.nrows() {
            for column in 0..delta.nrows() {
                let value = delta[(column, row)];
                // Rest is d = I and q = [I 0]: the root's block takes back what rest would add.
                let axis = if column < self.keys {
                    refined.c1[(row, column)] += value;
                    column % 3
                } else {
                    let column = column - self.keys;
                    refined.c2[(row, column)] += value;
                    column % 4
                };
                if axis < 3 {
                    refined.c2[(row, 4 * self.root + axis)] -= value;
                }
            }
        }
        refined
    }
}

/// Deviations from rest `[d - I, q - rest]`, 3n x (3P + 4J).
fn features(gradients: &Mat<f64>, poses: &Poses) -> Mat<f64> {
    let (keys, joints) = (gradients.ncols(), poses.stacked());
    Mat::from_fn(gradients.nrows(), keys + joints.ncols(), |row, column| {
        let identity = |axis: usize| f64::from(u8::from(row % 3 == axis));
        match column.checked_sub(keys) {
            None => gradients[(row, column)] - identity(column % 3),
            Some(column) => joints[(row, column)] - identity(column % 4),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};

    #[test]
    fn poses_that_count_twice_are_poses_that_are_there_twice() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 10, held_out: 0, seed: 5 });
        let regression = |frames: &[usize]| {
            let poses = Poses::new(&examples, frames);
            let number = |row: usize, column: usize| {
                let frame = frames[row / 3];
                ((frame * 7919 + row % 3 * 31 + column * 104_729) as f64).sin()
            };
            let gradients = Mat::from_fn(3 * frames.len(), 6, number);
            let residual = Mat::from_fn(3 * frames.len(), 8, |row, column| number(row, column + 9));
            Regression::new(&gradients, &poses, &residual, &[])
        };
        let weighted = regression(&[0, 1, 2, 3, 4]).and(&regression(&[5, 6, 7]), 2.0);
        let repeated = regression(&[0, 1, 2, 3, 4, 5, 6, 7, 5, 6, 7]);
        let joints = examples.joint_len();
        let nothing = Reduced { c1: Mat::zeros(8, 6), c2: Mat::zeros(8, 4 * joints) };
        let [a, b] = [weighted, repeated].map(|sums| sums.refine(&nothing, 1e-2));
        assert!((&a.c1 - &b.c1).norm_max() < 1e-9 && (&a.c2 - &b.c2).norm_max() < 1e-9);
        assert!(a.c1.norm_max() > 1e-3);
    }
}
