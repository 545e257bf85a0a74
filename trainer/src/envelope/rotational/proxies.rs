//! Proxies: P affine maps a pose and the vertices' weights on them (METHOD §1.7.1, S3 §3.1).

use super::super::blend::{Items, Maps, Weights, fit_maps, fit_weights};
use super::merge::MergeTree;
use super::surface::Surface;
use crate::progress::Progress;
use faer::Mat;
use serde::Serialize;

/// Name of the step.
pub const STEP: &str = "proxies";
/// Most rounds of weights and maps.
const ROUNDS: usize = 12;
/// Gain of a round, relative to the error, below which the alternation stops.
const GAIN: f64 = 2e-3;

/// How many proxies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProxyCount {
    /// Exactly so many.
    Fixed(usize),
    /// The fewest whose RMS error on the training frames is at most this, in units of the input.
    MaxError(f64),
}

/// Fitted proxies.
pub struct Proxies {
    /// Weights α of each vertex, at most K.
    pub weights: Weights,
    /// Maps T_l on the trajectory basis, r x 4P.
    pub maps: Maps,
    /// RMS error over vertices and training frames, in units of the input.
    pub rms: f64,
}

impl Proxies {
    /// Returns P.
    pub fn len(&self) -> usize {
        self.maps.len()
    }

    /// Returns whether there is no proxy.
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }
}

/// Fits proxies to a surface of n frames.
pub fn fit(
    surface: &Surface<'_>,
    tree: &MergeTree,
    frames: usize,
    count: ProxyCount,
    influences: usize,
    progress: &dyn Progress,
) -> Proxies {
    let items = vertex_items(surface);
    let most = surface.triangles.len();
    let at = |p: usize| {
        progress.step(STEP, ROUNDS);
        fit_at(surface, tree, &items, frames, p, influences, progress)
    };
    match count {
        ProxyCount::Fixed(p) => at(p.clamp(1, most)),
        ProxyCount::MaxError(limit) => fewest(at, most, limit),
    }
}

/// Doubles P until the error is met, then halves the bracket.
fn fewest(at: impl Fn(usize) -> Proxies, most: usize, limit: f64) -> Proxies {
    let (mut below, mut p) = (0, 4.min(most));
    let mut found = at(p);
    while found.rms > limit && p < most {
        below = p;
        p = (2 * p).min(most);
        found = at(p);
    }
    while p - below > 1 {
        let middle = below + (p - below) / 2;
        let tried = at(middle);
        if tried.rms <= limit {
            (p, found) = (middle, tried);
        } else {
            below = middle;
        }
    }
    found
}

fn fit_at(
    surface: &Surface<'_>,
    tree: &MergeTree,
    items: &Items<'_>,
    frames: usize,
    count: usize,
    influences: usize,
    progress: &dyn Progress,
) -> Proxies {
    let mut maps = group_maps(surface, &tree.cut(count));
    let rms = |errors: &[f64]| {
        (errors.iter().sum::<f64>() / (errors.len() * frames).max(1) as f64).sqrt()
    };
    let (mut weights, errors) = fit_weights(items, &maps, influences);
    let mut error = rms(&errors);
    for _ in 0..ROUNDS {
        progress.advance(1);
        maps = fit_maps(items, &weights, &maps);
        let (next, errors) = fit_weights(items, &maps, influences);
        let last = error;
        (weights, error) = (next, rms(&errors));
        if last - error < GAIN * last {
            break;
        }
    }
    Proxies { weights, maps, rms: error }
}

/// One row `[x̂ 1]` a vertex.
fn vertex_items<'a>(surface: &'a Surface<'_>) -> Items<'a> {
    let h = surface.rest.iter().flat_map(|x| [x[0], x[1], x[2], 1.0]).collect();
    Items { width: 4, rows: 1, h, y: &surface.vertices }
}

/// The affine map of each group of triangles, through its corners and points along its normals.
fn group_maps(surface: &Surface<'_>, group_of: &[usize]) -> Maps {
    let count = group_of.iter().max().map_or(0, |&g| g + 1);
    let rank = surface.vertices.nrows();
    let mut points = vec![nalgebra::Matrix4::<f64>::zeros(); count];
    let mut targets = Mat::<f64>::zeros(rank, 4 * count);
    for (triangle, &group) in group_of.iter().enumerate() {
        let corners = surface.triangles[triangle];
        let mut add = |x: [f64; 3], normal: bool, vertex: usize| {
            let h = nalgebra::Vector4::new(x[0], x[1], x[2], 1.0);
            points[group] += h * h.transpose();
            for (column, factor) in h.iter().enumerate() {
                let mut target = targets.col_mut(4 * group + column);
                for k in 0..rank {
                    let lift = if normal { surface.normals[(k, triangle)] } else { 0.0 };
                    target[k] += factor * (surface.vertices[(k, vertex)] + lift);
                }
            }
        };
        for corner in corners {
            add(surface.rest[corner], false, corner);
        }
        let normal = surface.rest_normals[triangle];
        let base = surface.rest[corners[0]];
        add(std::array::from_fn(|axis| base[axis] + normal[axis]), true, corners[0]);
    }
    let mut columns = Mat::zeros(rank, 4 * count);
    for (group, gram) in points.iter().enumerate() {
        let ridge = 1e-12 * gram.trace() + f64::MIN_POSITIVE;
        let inverse =
            (gram + nalgebra::Matrix4::identity() * ridge).try_inverse().unwrap_or_default();
        let inverse = Mat::from_fn(4, 4, |r, c| inverse[(r, c)]);
        columns.subcols_mut(4 * group, 4).copy_from(targets.subcols(4 * group, 4) * inverse);
    }
    Maps { width: 4, columns }
}

#[cfg(test)]
mod tests {
    use super::super::basis::basis;
    use super::*;
    use crate::demo::{DemoOptions, demo};
    use crate::envelope::motion::{Poses, trajectories};
    use crate::progress::Silent;

    #[test]
    fn the_fewest_proxies_within_an_error_are_found() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let moved = trajectories(&examples, &frames, &Poses::new(&examples, &frames));
        let basis = basis(&moved, examples.diagonal());
        let (surface, vectors) =
            Surface::new(&examples.rest, examples.solid_triangles(), &moved, basis);
        let tree = MergeTree::build(&surface, || ());
        let fit_to = |count| fit(&surface, &tree, frames.len(), count, 4, &Silent);
        let limit = 0.001 * examples.diagonal();
        let found = fit_to(ProxyCount::MaxError(limit));
        assert!(found.rms <= limit, "{} proxies leave {}", found.len(), found.rms);
        let fewer = fit_to(ProxyCount::Fixed(found.len() - 1));
        assert!(fewer.rms > limit, "{} proxies would do", fewer.len());

        // The error in coordinates is the error of the skinned vertices.
        let maps = &vectors * &found.maps.columns;
        let weights = &found.weights;
        let targets = super::super::validation::Targets {
            rest: &examples.rest,
            weights,
            trajectories: &moved,
        };
        assert!((targets.rms(&maps) - found.rms).abs() < 1e-3 * found.rms);
    }
}
