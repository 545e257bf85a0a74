//! Proxies: P affine maps per pose, and weights of the vertices on the maps (METHOD §1.7.1, S3 §3.1).

use super::merge::{MergeTree, regular_inverse};
use super::surface::Surface;
use super::{ProxyCount, RotationalOptions};
use crate::Error;
use crate::envelope::lbs::blend::{Alternation, Blend, Items, Weights};
use crate::numeric::affine::homogeneous;
use crate::numeric::columns;
use crate::progress::Progress;
use faer::Mat;
use serde::Serialize;

/// Name of the progress step.
const STEP: &str = "helpers";
/// Rounds from each start.
const FIRST: Alternation = Alternation { choices: 6, every: 3, rounds: 0, momentum: 0.9 };
/// Further rounds from the best start.
const ALTERNATION: Alternation = Alternation { choices: 14, every: 3, rounds: 10, momentum: 0.9 };

/// A tried number of proxies, and its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CountTrial {
    /// P.
    pub proxies: usize,
    /// RMS error over vertices and training frames, as a share of the diagonal.
    pub rms: f64,
}

/// Fitted proxies.
pub struct Proxies {
    /// Weights α of each vertex on at most K proxies.
    pub weights: Weights,
    /// Maps T_l on the trajectory basis, r x 4P.
    pub maps: Mat<f64>,
    /// RMS error over vertices and training frames.
    pub rms: f64,
    /// Tried P, and their errors.
    pub trials: Vec<CountTrial>,
}

impl Proxies {
    /// Returns P.
    pub(super) fn len(&self) -> usize {
        self.maps.ncols() / 4
    }

    /// Sorts the proxies by dominant joint, ascending.
    ///
    /// The dominant joint is argmax_j Σ_a α_al w_aj, with LBS weights w (METHOD §1.9).
    ///
    /// - `joints`: LBS weights of the V vertices on the joints.
    pub fn sort_by_joint(&mut self, joints: &Weights, joint_len: usize) {
        let mut shares = vec![vec![0.0; joint_len]; self.len()];
        for vertex in 0..joints.len() {
            for (l, alpha) in self.weights.of(vertex) {
                joints.of(vertex).for_each(|(joint, w)| shares[l][joint] += alpha * w);
            }
        }
        let strongest = |share: &Vec<f64>| {
            (0..joint_len).rev().max_by(|&a, &b| share[a].total_cmp(&share[b])).unwrap_or(0)
        };
        let dominant: Vec<usize> = shares.iter().map(strongest).collect();
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by_key(|&l| dominant[l]);
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &l)| rank[l] = k);
        self.weights = self.weights.renumbered(|l| rank[l]);
        self.maps = columns::some(&self.maps, &columns::of_maps(&order));
    }
}

/// Fits proxies to a surface. There are two starts: merged groups of triangles, and the joints with fewer groups. The
/// start with the smaller error is taken.
///
/// - `joints`: maps of the joints on the basis, r x 4J.
///
/// # Errors
/// A file cannot hold enough proxies to reach the requested error.
pub fn fit(
    surface: &Surface<'_>,
    tree: &MergeTree,
    joints: &Mat<f64>,
    options: &RotationalOptions,
    progress: &dyn Progress,
) -> Result<Proxies, Error> {
    let influences = options.influences;
    let items = Items::vertices(surface.rest, surface.vertices, surface.importance);
    let equations = (surface.rest.len() * surface.frames).max(1) as f64;
    let mut trials = Vec::new();
    let mut at = |proxies: usize| {
        let merged = group_maps(surface, &tree.cut(proxies));
        let from_joints = joint_start(surface, tree, joints, proxies);
        let advance = || progress.advance(1);
        let starts = 1 + from_joints.iter().len();
        progress.step(STEP, starts * FIRST.count() + ALTERNATION.count());
        let first = |start| FIRST.blend(&items, start, influences, advance);
        let nearer = |a: Blend, b: Blend| if b.error < a.error { b } else { a };
        let best = from_joints.map(first).into_iter().fold(first(merged), nearer);
        let Blend { weights, maps, error } =
            ALTERNATION.blend(&items, best.maps, influences, advance);
        let rms = (error / equations).sqrt();
        trials.push(CountTrial { proxies, rms });
        Proxies { weights, maps, rms, trials: Vec::new() }
    };
    let most = surface.triangles.len().min(options.method.proxies_max());
    let found = match options.proxies {
        ProxyCount::Fixed(p) => at(p.clamp(1, most)),
        ProxyCount::MaxError(limit) => fewest(&mut at, most, limit)?,
    };
    Ok(Proxies { trials, ..found })
}

/// Returns the maps of the joints, filled up with maps of groups to P maps; `None` if there are more than P joints.
/// Merging may not find the motion of a skin that follows its joints, so the joints are a separate start.
fn joint_start(
    surface: &Surface<'_>,
    tree: &MergeTree,
    joints: &Mat<f64>,
    proxies: usize,
) -> Option<Mat<f64>> {
    let group_len = (4 * proxies).checked_sub(joints.ncols()).filter(|_| joints.ncols() > 0)? / 4;
    let groups = match group_len {
        0 => Mat::zeros(joints.nrows(), 0),
        _ => group_maps(surface, &tree.cut(group_len)),
    };
    Some(faer::concat![[joints, groups]])
}

/// Finds the smallest P within an error: doubles P until the error is reached, then bisects.
fn fewest(
    at: &mut impl FnMut(usize) -> Proxies,
    most: usize,
    limit: f64,
) -> Result<Proxies, Error> {
    let (mut below, mut p) = (0, 4.min(most));
    let mut found = at(p);
    while found.rms > limit {
        if p == most {
            return Err(out_of_reach(limit, found.rms, p));
        }
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
    Ok(found)
}

/// Returns the error of a fit that cannot reach the requested error.
///
/// - `limit`: requested RMS error, as a share of the diagonal.
/// - `reached`: error with the largest possible number of proxies.
/// - `proxies`: this number.
pub(in crate::envelope) fn out_of_reach(limit: f64, reached: f64, proxies: usize) -> Error {
    Error::fit(format!(
        "{} % is out of reach: {proxies} helpers, the most there can be, come to {:.4} % of the \
         diagonal",
        100.0 * limit,
        100.0 * reached
    ))
}

/// Fits an affine map to each of l groups of triangles, r x 4l: to their corners, and to points along their normals.
pub(super) fn group_maps(surface: &Surface<'_>, group_of: &[usize]) -> Mat<f64> {
    let count = group_of.iter().max().map_or(0, |&g| g + 1);
    let rank = surface.vertices.nrows();
    let mut points = vec![nalgebra::Matrix4::<f64>::zeros(); count];
    let mut targets = Mat::<f64>::zeros(rank, 4 * count);
    for (triangle, &group) in group_of.iter().enumerate() {
        let corners = surface.triangles[triangle];
        let mut add = |x: [f64; 3], normal: bool, vertex: usize| {
            let h = homogeneous(&x);
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
        let inverse = regular_inverse(gram);
        let inverse = Mat::from_fn(4, 4, |r, c| inverse[(r, c)]);
        columns.subcols_mut(4 * group, 4).copy_from(targets.subcols(4 * group, 4) * inverse);
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::lbs::targets::Targets;
    use crate::envelope::lbs::training::Training;
    use crate::examples::Importance;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::basis::basis;
    use crate::progress::Silent;

    #[test]
    fn the_fewest_proxies_within_an_error_are_found() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let Training { rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent).unwrap();
        let basis = basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let fit_to = |proxies| {
            let options = RotationalOptions { proxies, ..RotationalOptions::default() };
            fit(&surface, &tree, &Mat::zeros(0, 0), &options, &Silent)
        };
        let found = fit_to(ProxyCount::MaxError(0.001)).unwrap();
        assert!(found.rms <= 0.001, "{} proxies leave {}", found.len(), found.rms);
        let fewer = fit_to(ProxyCount::Fixed(found.len() - 1)).unwrap();
        assert!(fewer.rms > 0.001, "{} proxies would do", fewer.len());
        assert!(found.trials.len() > 2);

        // The error in coordinates equals the error of the skinned vertices.
        let maps = &basis.vectors * &found.maps;
        let targets = Targets {
            rest: &rest,
            weights: &found.weights,
            trajectories: &trajectories,
            importance: Importance::UNIFORM,
        };
        assert!((targets.rms(&maps) - found.rms).abs() < 1e-3 * found.rms);
    }

    #[test]
    fn an_unreachable_error_reports_the_error_that_was_reached() {
        let examples = demo(&DemoOptions { vertices: 100, poses: 10, held_out: 0, seed: 1 });
        let Training { rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent).unwrap();
        let most = triangles.len();
        let basis = basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let fit_to = |proxies| {
            let options = RotationalOptions { proxies, ..RotationalOptions::default() };
            fit(&surface, &tree, &Mat::zeros(0, 0), &options, &Silent)
        };
        let reached = fit_to(ProxyCount::Fixed(most)).unwrap().rms;
        assert!(reached > 0.0 && reached < 0.01);
        let error = fit_to(ProxyCount::MaxError(1e-30)).err().unwrap();
        assert_eq!(error.message(), out_of_reach(1e-30, reached, most).message());
    }
}
