//! Refinement of c1 and c2 on the training meshes.
//!
//! The Poisson reconstruction trusts the predicted gradients; where the prediction errs in a way
//! that repeats, the training meshes show it. The correction Δ of `[c1 c2]` is a ridge regression
//! of what the reduced reconstruction leaves over on the gradients and joints themselves, so the
//! evaluation keeps its form and its cost. It acts on `d - I` and `q - rest`, and the root's block
//! of c2, which multiplies a constant, takes up what that subtracts: the rest pose stays exact.

use super::super::motion::Poses;
use super::super::targets::Targets;
use super::reduce::Reduced;
use crate::numeric::affine::homogeneous;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;

/// Share of the mean diagonal that decides directions of the palette no vertex sees.
const UNSEEN: f64 = 1e-6;

/// The training meshes as the palette sees them.
pub struct Projection {
    /// Σ φ φᵀ, 4P x 4P.
    pub gram: Mat<f64>,
    /// The trajectories weighted onto the palette, 3n x 4P.
    onto: Mat<f64>,
}

impl Projection {
    /// Sums over the vertices.
    pub fn new(targets: &Targets<'_>, proxy_len: usize) -> Self {
        let mut onto = Mat::zeros(targets.trajectories.nrows(), 4 * proxy_len);
        for (vertex, x) in targets.rest.iter().enumerate() {
            let h = homogeneous(x) * targets.importance.of(vertex);
            let y = targets.trajectories.col_as_slice(vertex);
            for (a, alpha) in targets.weights.of(vertex) {
                for i in 0..4 {
                    let phi = alpha * h[i];
                    for (sum, value) in onto.col_as_slice_mut(4 * a + i).iter_mut().zip(y) {
                        *sum += phi * value;
                    }
                }
            }
        }
        Self { gram: gram(targets, 0..proxy_len), onto }
    }

    /// What maps (3n x 4P) leave over, as maps, by least squares over the vertices.
    pub fn residual(&self, maps: &Mat<f64>) -> Mat<f64> {
        let left = &self.onto - maps * &self.gram;
        let mut gram = self.gram.clone();
        let mean = gram.diagonal().column_vector().sum() / gram.nrows().max(1) as f64;
        solve_ridge(&mut gram, left.transpose().to_owned(), UNSEEN * mean).transpose().to_owned()
    }
}

/// Sums φ φᵀ over the vertices, for a span of l maps of the palette: 4l x 4l.
pub fn gram(targets: &Targets<'_>, span: Range<usize>) -> Mat<f64> {
    let mut gram = Mat::zeros(4 * span.len(), 4 * span.len());
    for (vertex, x) in targets.rest.iter().enumerate() {
        let h = homogeneous(x);
        let counted = h * targets.importance.of(vertex);
        let own = targets.weights.of(vertex).filter(|(map, _)| span.contains(map));
        for (a, alpha) in own.clone() {
            for (b, beta) in own.clone() {
                for i in 0..4 {
                    for j in 0..4 {
                        let (row, column) = (4 * (b - span.start) + j, 4 * (a - span.start) + i);
                        gram[(row, column)] += alpha * counted[i] * beta * h[j];
                    }
                }
            }
        }
    }
    gram
}

/// The regression of a palette's residual on the deviations of its inputs from rest.
pub struct Regression {
    gram: Mat<f64>,
    right: Mat<f64>,
    rows: usize,
    keys: usize,
    root: usize,
}

impl Regression {
    /// Sums over the poses outside a range: gradients (3n x 3P), residual maps (3n x 4P).
    pub fn new(
        gradients: &Mat<f64>,
        poses: &Poses,
        residual: &Mat<f64>,
        left_out: &Range<usize>,
    ) -> Self {
        let all = features(gradients, poses);
        let (mut gram, mut right) = (all.transpose() * &all, all.transpose() * residual);
        let (start, len) = (3 * left_out.start, 3 * left_out.len());
        let (x, r) = (all.subrows(start, len), residual.subrows(start, len));
        gram -= x.transpose() * x;
        right -= x.transpose() * r;
        let rows = all.nrows() - len;
        Self { gram, right, rows, keys: gradients.ncols(), root: poses.root() }
    }

    /// Adds Δ at a ridge of `strength` an equation to c1 and c2.
    pub fn refine(&self, reduced: &Reduced, strength: f64) -> Reduced {
        let ridge = strength * self.rows as f64;
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

/// Solves `(gram + ridge I) x = right`; no correction where rounding makes it indefinite.
fn solve_ridge(gram: &mut Mat<f64>, right: Mat<f64>, ridge: f64) -> Mat<f64> {
    for i in 0..gram.nrows() {
        gram[(i, i)] += ridge + f64::MIN_POSITIVE;
    }
    match gram.llt(Side::Lower) {
        Ok(factor) => factor.solve(right),
        Err(_) => Mat::zeros(right.nrows(), right.ncols()),
    }
}
