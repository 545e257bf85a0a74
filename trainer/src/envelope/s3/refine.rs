//! Refinement of c1 and c2 on the training meshes.
//!
//! The Poisson reconstruction trusts the predicted gradients; where the prediction errs in a way
//! that repeats, the training meshes show it. The correction Δ of `[c1 c2]` is a ridge regression
//! of what the reduced reconstruction leaves over on the gradients and joints themselves, so the
//! evaluation keeps its form and its cost. It acts on `d - I` and `q - rest`, and the root's block
//! of c2, which multiplies a constant, takes up what that subtracts: the rest pose stays exact.

use super::reduce::Reduced;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::targets::in_poses;
use crate::numeric::columns::solve_ridge;
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
