//! Keys: P gradient sequences whose blends move every triangle's edges (METHOD §1.7.2, S3 §3.2). Which
//! joints a key follows is chosen in `rotation`.

use super::proxies::Proxies;
use super::surface::Surface;
use crate::envelope::lbs::blend::{Alternation, Blend, Items, Maps, Weights};
use crate::examples::Importance;
use crate::progress::Progress;
use faer::Mat;
use nalgebra::Matrix3;

/// Weight of n̂ as a third edge, which decides D_l on flat support.
const NORMAL_WEIGHT: f64 = 0.1;
/// Name of the step.
const STEP: &str = "keys";
const ALTERNATION: Alternation = Alternation { choices: 3, every: 1, rounds: 0, momentum: 0.0 };

/// Fitted keys.
pub struct Keys {
    /// Weights β of each triangle, at most K.
    pub weights: Weights,
    /// Gradients D_l on the trajectory basis, r x 3P.
    gradients: Maps,
    /// RMS error of the edges over triangles and training frames.
    pub rms: f64,
}

/// Fits keys to the edges of a surface, starting from the proxies' linear parts.
pub fn fit(
    surface: &Surface<'_>,
    proxies: &Proxies,
    influences: usize,
    progress: &dyn Progress,
) -> Keys {
    progress.step(STEP, ALTERNATION.count());
    let y = edge_targets(surface);
    let counts: Vec<f64> =
        (0..surface.triangles.len()).map(|t| surface.triangle_importance(t)).collect();
    let importance = Importance::by(Some(&counts));
    let items = Items::new([3, 3], edge_rows(surface), &y, importance);
    let columns = Mat::from_fn(surface.vertices.nrows(), 3 * proxies.len(), |k, column| {
        proxies.maps.columns[(k, 4 * (column / 3) + column % 3)]
    });
    let start = Maps { width: 3, columns };
    let Blend { weights, maps, error } =
        ALTERNATION.blend(&items, start, influences, || progress.advance(1));
    let edges = (2 * surface.triangles.len() * surface.frames).max(1) as f64;
    Keys { weights, gradients: maps, rms: (error / edges).sqrt() }
}

impl Keys {
    /// Returns P.
    pub fn len(&self) -> usize {
        self.gradients.len()
    }

    /// Returns whether there is no key.
    pub fn is_empty(&self) -> bool {
        self.gradients.is_empty()
    }

    /// Returns the gradients of a key over the frames, given the basis trajectories (3n x r).
    pub fn sequence(&self, key: usize, basis: &Mat<f64>) -> Vec<Matrix3<f64>> {
        let stacked = basis * self.gradients.columns.subcols(3 * key, 3);
        (0..stacked.nrows() / 3)
            .map(|frame| Matrix3::from_fn(|r, c| stacked[(3 * frame + r, c)]))
            .collect()
    }
}

/// Three rows a triangle: its two edges and its normal at a small weight.
fn edge_rows(surface: &Surface<'_>) -> Vec<f64> {
    let mut h = Vec::with_capacity(9 * surface.triangles.len());
    for triangle in 0..surface.triangles.len() {
        for edge in surface.rest_edges(triangle) {
            h.extend_from_slice(edge.as_slice());
        }
        h.extend((surface.rest_normals[triangle] * NORMAL_WEIGHT).iter());
    }
    h
}

/// What the rows of [`edge_rows`] become, r x 3T.
fn edge_targets(surface: &Surface<'_>) -> Mat<f64> {
    let mut y = Mat::zeros(surface.vertices.nrows(), 3 * surface.triangles.len());
    for (triangle, &[a, b, c]) in surface.triangles.iter().enumerate() {
        let first = surface.vertices.col(a);
        for (edge, corner) in [b, c].into_iter().enumerate() {
            y.col_mut(3 * triangle + edge).copy_from(surface.vertices.col(corner) - first);
        }
        let normal = faer::Scale(NORMAL_WEIGHT) * surface.normals.col(triangle);
        y.col_mut(3 * triangle + 2).copy_from(normal);
    }
    y
}

#[cfg(test)]
mod tests {
    use super::super::merge::MergeTree;
    use super::super::{ProxyCount, RotationalOptions, proxies};
    use super::*;
    use crate::envelope::lbs::training::Training;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::basis::basis;
    use crate::progress::Silent;

    #[test]
    fn an_affine_motion_needs_one_key_and_it_is_the_gradient() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 6, held_out: 0, seed: 1 });
        let Training { rest, triangles, .. } = Training::new(&examples, &Silent).unwrap();
        let affine = |frame: f64| {
            Matrix3::new(1.0, 0.2 * frame, 0.0, -0.1, 1.0 + 0.1 * frame, 0.3, 0.0, 0.0, 1.0)
        };
        let moved = Mat::from_fn(3 * 4, rest.len(), |row, vertex| {
            (affine((row / 3) as f64) * nalgebra::Vector3::from(rest[vertex]))[row % 3] + row as f64
        });
        let basis = basis(&moved);
        let surface = Surface::new(&rest, triangles, &moved, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let options =
            RotationalOptions { proxies: ProxyCount::Fixed(1), ..RotationalOptions::default() };
        let joints = Mat::zeros(0, 0);
        let proxies = proxies::fit(&surface, &tree, &joints, &options, &Silent).unwrap();
        let keys = fit(&surface, &proxies, 4, &Silent);
        for (frame, found) in keys.sequence(0, &basis.vectors).iter().enumerate() {
            // The third edge n̂ is not affine, so it pulls, by its small weight.
            assert!((found - affine(frame as f64)).amax() < 0.02, "{found}");
        }
        assert!(keys.rms < 2e-3, "{}", keys.rms);
    }

    #[test]
    fn keys_move_the_edges_of_a_bending_arm() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let Training { rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent).unwrap();
        let basis = basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let with = |count| {
            let options = RotationalOptions {
                proxies: ProxyCount::Fixed(count),
                ..RotationalOptions::default()
            };
            let joints = Mat::zeros(0, 0);
            let proxies = proxies::fit(&surface, &tree, &joints, &options, &Silent).unwrap();
            fit(&surface, &proxies, 4, &Silent).rms
        };
        assert!(with(20) < 0.5 * with(5));
    }
}
