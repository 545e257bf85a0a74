//! S3 to the letter. This table lists the differences from the other rotational fits:
//!
//! | S3 | as published | other fits |
//! |---|---|---|
//! | §1.2, W and u | coordinate descent from `u = Σ\|θ\|\|ρ\| / Σ\|θ\|²`, u ≥ 0 ([`rotation`](super::rotation)) | the closed form over both signs |
//! | §1.3, H | least squares with a free bias, `vec(S) = H [θ_b1; θ_b2; 1]`; the rest pose is not exact ([`keys`](super::keys)) | a ridge, and no bias |
//! | §2.2, F | the vertices whose LBS error is below a threshold ([`setting`]) | a fraction by cross-validation |
//! | Eq. 2 and 5 | vertices of F keep their LBS positions: they follow the joints, which come after the proxies in the palette | F follows proxies that anchors pull to LBS |
//! | Eq. 6 | `c1 = a⁻¹ b1`, `c2 = a⁻¹ b2` | anchors by cross-validation, and the refinement |
//! | §3.1, α and T | both fitted again after every merge ([`fit_proxies`]) | fitted after the last merge |
//!
//! In Eq. 4 all vertices follow proxies. But a (Eq. 6) has no equation for the effect of proxies on F. If F followed
//! proxies that only free vertices determine, the whole mesh would have errors of 6 and 9 % (METHOD §1.7).
//!
//! S3 leaves some details open, which are as in the other fits. Keys are fitted with the normal as a third edge of
//! small weight. A vertex has few influences, and u is at most 4. The branch of ρ at π is handled. Slips in the
//! equations of S3 are corrected (METHOD §1.7).

use super::keys::GradientPredictor;
use super::merge::MergeTree;
use super::proxies::{CountTrial, Proxies, group_maps, out_of_reach};
use super::reduce::{Anchors, Reduced};
use super::surface::Surface;
use super::validation::Setting;
use super::{ProxyCount, RotationalOptions};
use crate::Error;
use crate::envelope::lbs::blend::{Blend, InTurn, Items, Supports, Weights};
use crate::envelope::model::{Key, Reconstruction, Shear};
use crate::numeric::affine::homogeneous;
use crate::numeric::columns;
use crate::progress::Progress;
use faer::Mat;
use nalgebra::Matrix3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// S3 has no anchors, so a can be singular. This happens if a proxy moves only vertices of F, if a part of the mesh has
/// no vertex in F, if a patch is flat, or if the weights of two proxies are proportional. This anchor is very weak and
/// only determines such undetermined maps.
const ANCHORS: Anchors = Anchors { near_rigid: 0.0, patch: 1e-6 };

/// Number of groups in the first trial under an error.
const FIRST: usize = 8;
/// Factor of the number of groups from one trial to the next.
const NEXT: usize = 4;

/// Returns F as a fraction of the vertices, and the anchors. F holds the vertices whose LBS error is at most the RMS
/// error of the mesh. S3 has a threshold for that error, but states no value. A fixed length would put no vertex of one
/// set and all vertices of another set into F.
///
/// - `lbs_errors`: squared errors summed over the poses, V.
pub fn setting(lbs_errors: &[f64]) -> Setting {
    let count = lbs_errors.len().max(1) as f64;
    let mean = lbs_errors.iter().sum::<f64>() / count;
    let within = lbs_errors.iter().filter(|error| **error <= mean).count();
    Setting { near_rigid_fraction: within as f64 / count, anchors: ANCHORS }
}

/// Returns weights on P proxies, then J joints. Vertices of F follow the joints, other vertices the proxies.
pub fn fixed_on_joints(proxies: &Proxies, joints: &Weights, fixed: &[bool]) -> Weights {
    let first = proxies.len();
    let lists = fixed.iter().enumerate().map(|(vertex, fixed)| match fixed {
        true => joints.of(vertex).map(|(joint, w)| (first + joint, w)).collect(),
        false => proxies.weights.of(vertex).collect(),
    });
    Weights::from_lists(proxies.weights.most().max(joints.most()), lists)
}

/// Merges the triangles of a surface into proxies: into a fixed number, or into the smallest number within an error.
/// All weights and maps are fitted again after every merge (S3 §3.1).
///
/// Thousands of groups would make that too slow. So the first merges come from `tree`, where a merge refits only the
/// merged group. They end at twice the number of proxies that is asked for.
///
/// # Errors
/// A file cannot hold enough proxies to reach the requested error.
pub fn fit_proxies(
    surface: &Surface<'_>,
    tree: &MergeTree,
    options: &RotationalOptions,
    progress: &dyn Progress,
) -> Result<Proxies, Error> {
    let all = surface.triangles.len();
    let max = all.min(options.method.proxies_max());
    let from = |groups: usize| {
        let group_of = tree.cut(groups);
        let maps = group_maps(surface, &group_of);
        Groups::new(surface, group_of, options.influences, maps, progress)
    };
    let (mut groups, min, limit) = match options.proxies {
        ProxyCount::Fixed(proxies) => {
            let proxies = proxies.clamp(1, max);
            progress.step("helpers", proxies);
            (from((2 * proxies).min(all)), proxies, f64::INFINITY)
        }
        ProxyCount::MaxError(limit) => {
            progress.step("helpers", 1);
            let mut groups = from(FIRST.min(max));
            while groups.rms() > limit {
                if groups.len() == max {
                    return Err(out_of_reach(limit, groups.rms(), max));
                }
                groups = from((NEXT * groups.len()).min(max));
            }
            (groups, 1, limit)
        }
    };
    let neighbours = surface.neighbours();
    let mut trials = vec![groups.trial()];
    while groups.len() > min {
        let (from, into) = groups.cheapest_merge(&neighbours);
        let next = groups.merged(from, into, progress);
        if next.rms() > limit {
            break;
        }
        groups = next;
        trials.push(groups.trial());
    }
    let rms = groups.rms();
    Ok(Proxies { weights: groups.blend.weights, maps: groups.blend.maps, rms, trials })
}

/// Returns the reconstruction of P predictors for a file, whose keys have no bias.
///
/// With a bias B a key is `D = R (I + sym(H θ)) + R B` (S3 §1.3). A second key with the same rotation and no shear is
/// R. Columns `3k + i` of c1 multiply the first key; `Σ_i c1[.., 3k + i] B[m, i]` in column m multiplies the second
/// key. So P predictors with a bias become 2P keys.
///
/// A file has as many proxies as keys. If `reduced` has more transforms, keys are repeated; if it has fewer, the
/// further proxies are zero, and no vertex may follow them.
pub fn reconstruction(predictors: &[GradientPredictor], reduced: &Reduced) -> Reconstruction {
    let p = predictors.len();
    let mut keys: Vec<Key> = predictors.iter().map(|predictor| predictor.key.clone()).collect();
    if predictors.iter().all(|predictor| predictor.bias == Matrix3::zeros()) {
        return Reconstruction { keys, c1: reduced.c1.clone(), c2: reduced.c2.clone() };
    }
    keys.extend_from_within(..);
    keys[p..].iter_mut().for_each(|key| key.shear = Shear::zeros());
    let rows = reduced.c1.nrows();
    let len = (2 * p).max(rows / 4);
    keys.resize(len, keys[p].clone());
    let mut c1 = Mat::zeros(4 * len, 3 * len);
    let mut c2 = Mat::zeros(4 * len, reduced.c2.ncols());
    c1.submatrix_mut(0, 0, rows, 3 * p).copy_from(&reduced.c1);
    c2.subrows_mut(0, rows).copy_from(&reduced.c2);
    for (k, predictor) in predictors.iter().enumerate() {
        let bias = Mat::from_fn(3, 3, |i, m| predictor.bias[(m, i)]);
        let own = reduced.c1.subcols(3 * k, 3) * bias;
        c1.submatrix_mut(0, 3 * (p + k), rows, 3).copy_from(own);
    }
    Reconstruction { keys, c1, c2 }
}

/// Groups of triangles during the merging, and the proxies fitted to them.
struct Groups<'a> {
    surface: &'a Surface<'a>,
    influences: usize,
    /// Group of each triangle, numbered from 0.
    group_of: Vec<usize>,
    blend: Blend,
}

impl<'a> Groups<'a> {
    fn new(
        surface: &'a Surface<'a>,
        group_of: Vec<usize>,
        influences: usize,
        maps: Mat<f64>,
        progress: &dyn Progress,
    ) -> Self {
        let items = Items::vertices(surface.rest, surface.vertices, surface.importance);
        let supports = Supports::Free(influences);
        let maps = items.maps(&items.weights(&maps, supports).0, &maps);
        let (weights, error) = items.weights(&maps, supports);
        progress.advance(1);
        Self { surface, influences, group_of, blend: Blend { weights, maps, error } }
    }

    fn len(&self) -> usize {
        self.blend.maps.ncols() / 4
    }

    /// Merges group A into B, then fits all weights and maps again. The maps of the other groups are the start.
    fn merged(&self, a: usize, b: usize, progress: &dyn Progress) -> Self {
        let number = |group: usize| if group > a { group - 1 } else { group };
        let group_of =
            self.group_of.iter().map(|&group| number(if group == a { b } else { group })).collect();
        let kept: Vec<usize> = (0..self.len()).filter(|&group| group != a).collect();
        let maps = columns::some(&self.blend.maps, &columns::of_maps(&kept));
        Self::new(self.surface, group_of, self.influences, maps, progress)
    }

    /// Finds the merge A → B with the smallest `E_{A→B} = Σ_{a∈A} |y_a - T_B x̂_a|²` among groups that share an edge.
    /// If no groups share an edge, compares all pairs.
    fn cheapest_merge(&self, neighbours: &[BTreeSet<u32>]) -> (usize, usize) {
        let across = |(a, others): (&usize, &BTreeSet<u32>)| -> Vec<_> {
            others.iter().map(|&other| (*a, self.group_of[other as usize])).collect()
        };
        let mut moves: BTreeSet<_> =
            self.group_of.iter().zip(neighbours).flat_map(across).collect();
        moves.retain(|(a, b)| a != b);
        if moves.is_empty() {
            let pairs = (0..self.len()).flat_map(|a| (0..self.len()).map(move |b| (a, b)));
            moves = pairs.filter(|(a, b)| a != b).collect();
        }
        let mut vertices = vec![BTreeSet::new(); self.len()];
        for (&group, corners) in self.group_of.iter().zip(&self.surface.triangles) {
            vertices[group].extend(corners);
        }
        let cost = |&(a, b): &(usize, usize)| -> f64 {
            vertices[a].iter().map(|&vertex| self.squared_error(vertex, b)).sum()
        };
        let moves: Vec<_> = moves.into_iter().collect();
        let costs: Vec<f64> = moves.par_iter().map(cost).collect();
        let cheapest = (0..moves.len()).min_by(|&i, &j| costs[i].total_cmp(&costs[j]));
        cheapest.map_or((0, 1), |cheapest| moves[cheapest])
    }

    /// Returns the squared error of a vertex that follows only one group's map, times its weight.
    fn squared_error(&self, vertex: usize, group: usize) -> f64 {
        let h = homogeneous(&self.surface.rest[vertex]);
        let column = |c: usize| self.blend.maps.col_as_slice(4 * group + c);
        let [x, y, z, one] = [0, 1, 2, 3].map(column);
        let truth = self.surface.vertices.col_as_slice(vertex);
        let left = |k: usize| truth[k] - h[0] * x[k] - h[1] * y[k] - h[2] * z[k] - h[3] * one[k];
        let squared: f64 = (0..truth.len()).map(|k| left(k) * left(k)).sum();
        self.surface.importance.of(vertex) * squared
    }

    fn rms(&self) -> f64 {
        let equations = (self.surface.rest.len() * self.surface.frames).max(1) as f64;
        (self.blend.error / equations).sqrt()
    }

    fn trial(&self) -> CountTrial {
        CountTrial { proxies: self.len(), rms: self.rms() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Method;
    use super::super::keys::predict_stacked;
    use super::super::validation::near_rigid;
    use super::*;
    use crate::envelope::fitted::Fitted;
    use crate::envelope::lbs::training::Training;
    use crate::examples::Importance;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::basis::basis;
    use crate::numeric::so3;
    use crate::progress::Silent;

    #[test]
    fn vertices_with_lbs_errors_below_the_mean_are_near_rigid() {
        let fixed = |errors: &[f64]| near_rigid(errors, setting(errors).near_rigid_fraction);
        assert_eq!(fixed(&[9.0, 1.0, 3.0, 4.0, 0.0]), [false, true, true, false, true]);
        assert_eq!(fixed(&[2.0, 2.0]), [true, true]);
        assert_eq!(fixed(&[]), [false; 0]);
    }

    #[test]
    fn merging_stops_at_the_given_number_or_error() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let Training { rest, triangles, trajectories, .. } =
            Training::new(&examples, &Silent).unwrap();
        let basis = basis(&trajectories);
        let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let fit_to = |proxies| {
            let method = Method::Published;
            let options = RotationalOptions { proxies, method, ..RotationalOptions::default() };
            fit_proxies(&surface, &tree, &options, &Silent)
        };
        // Merging the most expensive groups instead of the cheapest would leave an error of 0.016 with five proxies.
        for (count, most) in [(1, 0.1), (5, 8e-3), (12, 1e-3), (40, 6e-4)] {
            let found = fit_to(ProxyCount::Fixed(count)).unwrap();
            let tried: Vec<_> = found.trials.iter().map(|trial| trial.proxies).collect();
            assert_eq!(tried, (count..=2 * count).rev().collect::<Vec<_>>());
            assert_eq!(found.len(), count);
            assert!(found.rms < most, "{count}: {}", found.rms);
        }
        let found = fit_to(ProxyCount::MaxError(2e-3)).unwrap();
        assert!(found.rms <= 2e-3 && found.trials.len() > 1, "{:?}", found.trials);
        let error = fit_to(ProxyCount::MaxError(1e-30)).err().unwrap().to_string();
        let most = Method::Published.proxies_max();
        let reached =
            format!(" % is out of reach: {most} helpers, the most there can be, come to 0.00");
        assert!(error.contains(&reached), "{error}");
    }

    #[test]
    fn gradients_with_an_offset_at_rest_are_reproduced_also_by_keys_without_a_bias() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let (poses, parents) = (&training.poses, &training.skeleton.parents);
        let offset = Matrix3::new(1.2, 0.05, 0.0, 0.05, 0.9, 0.03, 0.0, 0.03, 1.01);
        let moving = (0..poses.joint_len()).filter(|&joint| poses.angle_ranges()[joint] > 0.5);
        let sequences = moving.map(|joint| -> Vec<_> {
            let turn = |pose| so3::exp(poses.angle(pose, joint));
            (0..poses.len()).map(|i| poses.parent_rotation(i, joint) * turn(i) * offset).collect()
        });
        let fit = |d: Vec<_>| GradientPredictor::fit(poses, parents, &d, Method::Published);
        let sequences: Vec<_> = sequences.collect();
        let predictors: Vec<_> = sequences.iter().cloned().map(fit).collect();
        for (predictor, sequence) in predictors.iter().zip(&sequences) {
            for (pose, expected) in sequence.iter().enumerate() {
                let found = predictor.predict(poses, pose);
                assert!((found - expected).amax() < 1e-6, "pose {pose}: {found}{expected}");
            }
        }

        let (p, j) = (predictors.len(), poses.joint_len());
        let number = |row: usize, column: usize| ((row * 7919 + column * 104_729) as f64).sin();
        let proxies = Reduced {
            c1: Mat::from_fn(4 * p, 3 * p, number),
            c2: Mat::from_fn(4 * p, 4 * j, |row, column| number(row + 1, column)),
        };
        for (reduced, len) in [(proxies.and_joints(), (2 * p).max(p + j)), (proxies, 2 * p)] {
            let expected = reduced.palette(&predict_stacked(&predictors, poses), poses);
            let reconstruction = reconstruction(&predictors, &reduced);
            let weights = training.lbs.weights.clone();
            let found =
                Fitted::new(&training, weights, Some(reconstruction)).envelope.palettes(poses);
            assert_eq!((p > 1, found.ncols()), (true, 4 * len));
            let apart = (found.subcols(0, expected.ncols()) - &expected).norm_max();
            assert!(apart < 1e-12 * expected.norm_max(), "{apart}");
        }
    }
}
