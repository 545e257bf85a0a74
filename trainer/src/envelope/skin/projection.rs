//! The training meshes as a palette sees them: summed over the vertices by what they follow.

use super::targets::Targets;
use crate::numeric::affine::homogeneous;
use crate::numeric::ridge::solve_ridge;
use faer::Mat;
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
