//! Training meshes projected onto a palette: sums over the vertices of each palette transform.

use super::targets::Targets;
use crate::numeric::affine::homogeneous;
use crate::numeric::columns::{dot, solve_ridge};
use faer::Mat;
use std::ops::Range;

/// Ridge as a share of the mean diagonal. It decides directions of the palette that move no vertex.
pub const RIDGE: f64 = 1e-6;

/// Training meshes projected onto a palette of P transforms.
pub struct Projection {
    /// Σ φ φᵀ, 4P x 4P.
    pub gram: Mat<f64>,
    /// The trajectories weighted onto the palette, 3n x 4P.
    onto: Mat<f64>,
    /// The transforms with the least squared error, 3n x 4P.
    nearest: Mat<f64>,
    /// Residual `onto - nearest gram`, 3n x 4P.
    slope: Mat<f64>,
    /// Mean squared error of `nearest` over vertices and poses.
    floor: f64,
    vertices: usize,
}

impl Projection {
    /// Projects the training meshes.
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
        let gram = gram(targets, 0..proxy_len);
        let nearest = nearest(&gram, &onto);
        let slope = &onto - &nearest * &gram;
        let floor = targets.rms(&nearest).powi(2);
        Self { gram, onto, nearest, slope, floor, vertices: targets.rest.len() }
    }

    /// Fits transforms to the residual of given transforms, by least squares over the vertices; both 3n x 4P.
    pub fn residual(&self, maps: &Mat<f64>) -> Mat<f64> {
        nearest(&self.gram, &(&self.onto - maps * &self.gram))
    }

    /// Returns the RMS error of transforms over vertices and poses.
    ///
    /// - `maps`: 3n x 4P.
    pub fn rms(&self, maps: &Mat<f64>) -> f64 {
        let difference = maps - &self.nearest;
        let weighted = &difference * &self.gram - &self.slope * faer::Scale(2.0);
        let squared: f64 = (0..difference.ncols())
            .map(|column| dot(difference.col_as_slice(column), weighted.col_as_slice(column)))
            .sum();
        let count = (self.vertices * maps.nrows() / 3).max(1) as f64;
        (self.floor + squared / count).max(0.0).sqrt()
    }
}

/// Solves `maps gram = onto` for the transforms with the least squared error.
fn nearest(gram: &Mat<f64>, onto: &Mat<f64>) -> Mat<f64> {
    let mut gram = gram.clone();
    let mean = gram.diagonal().column_vector().sum() / gram.nrows().max(1) as f64;
    solve_ridge(&mut gram, onto.transpose().to_owned(), RIDGE * mean).transpose().to_owned()
}

/// Sums φ φᵀ over the vertices, for a span of l palette transforms: 4l x 4l.
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
                        let place = (4 * (b - span.start) + j, 4 * (a - span.start) + i);
                        gram[place] += alpha * counted[i] * beta * h[j];
                    }
                }
            }
        }
    }
    gram
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::lbs::training::Training;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    #[test]
    fn errors_equal_the_errors_over_all_vertices() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 8, held_out: 0, seed: 2 });
        let training = Training::new(&examples, &Silent).unwrap();
        let targets = training.targets(&training.lbs.weights);
        let palette = training.poses.stacked();
        let projection = Projection::new(&targets, palette.ncols() / 4);
        let noise = Mat::from_fn(palette.nrows(), palette.ncols(), |row, column| {
            1e-3 * ((row * 7919 + column * 104_729) as f64).sin()
        });
        for maps in [&palette, &(&palette + &noise)] {
            let (found, expected) = (projection.rms(maps), targets.rms(maps));
            assert!((found - expected).abs() < 1e-9 * expected, "{found} for {expected}");
        }
    }
}
