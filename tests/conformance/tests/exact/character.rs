//! A small character with all inputs of a reduction.

use conformance::poses::rigid_motion;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_trainer::envelope::lbs::blend::Weights;
use sinew_trainer::envelope::lbs::training::Training;
use sinew_trainer::envelope::lbs::weights;
use sinew_trainer::envelope::s3::keys::{self, GradientPredictor};
use sinew_trainer::envelope::s3::merge::MergeTree;
use sinew_trainer::envelope::s3::reduce::{Anchors, Reduction};
use sinew_trainer::envelope::s3::surface::Surface;
use sinew_trainer::envelope::s3::{Method, ProxyCount, RotationalOptions, proxies};
use sinew_trainer::examples::{Examples, Importance};
use sinew_trainer::numeric::affine::{after, from_rows, homogeneous, to_rows};
use sinew_trainer::progress::Silent;

const PROXIES: usize = 9;
const INFLUENCES: usize = 4;

/// A fitted character; lengths are in units of the rest diagonal.
pub(crate) struct Character<'a> {
    pub(crate) joint_len: usize,
    /// The rest mesh and the training frames.
    pub(crate) training: Training<'a>,
    /// α.
    pub(crate) proxies: Weights,
    /// β.
    pub(crate) keys: Weights,
    /// w.
    pub(crate) joints: Weights,
    /// The quarter of the vertices with the least LBS error.
    pub(crate) fixed: Vec<bool>,
    /// D_l for every pose; P lists.
    pub(crate) sequences: Vec<Vec<Matrix3<f64>>>,
}

impl<'a> Character<'a> {
    pub(crate) fn fit(examples: &'a Examples) -> Self {
        let training = Training::new(examples, &Silent).expect("there are poses and triangles");
        let Training { rest, triangles, poses, trajectories, .. } = &training;
        let (joints, errors) = weights::fit(rest, trajectories, poses, INFLUENCES, None);
        let basis = training.basis();
        let surface =
            Surface::new(rest, triangles.clone(), trajectories, basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        let count = ProxyCount::Fixed(PROXIES);
        let method = Method::Unrefined;
        let options = RotationalOptions { proxies: count, influences: INFLUENCES, method };
        let proxies = proxies::fit(&surface, &tree, &Mat::zeros(0, 0), &options, &Silent);
        let proxies = proxies.expect("a fixed number can be fitted");
        let keys = keys::fit(&surface, &proxies, INFLUENCES, &Silent);
        let mut sorted = errors.clone();
        sorted.sort_by(f64::total_cmp);
        let threshold = sorted[sorted.len() / 4];
        Self {
            joint_len: examples.joint_len(),
            sequences: keys.sequences(&basis.vectors),
            fixed: errors.iter().map(|&error| error < threshold).collect(),
            proxies: proxies.weights,
            keys: keys.weights,
            joints,
            training,
        }
    }

    pub(crate) fn proxy_len(&self) -> usize {
        self.sequences.len()
    }

    pub(crate) fn reduction(&self, anchors: Anchors) -> Reduction<'_> {
        Reduction {
            rest: &self.training.rest,
            triangles: &self.training.triangles,
            proxies: &self.proxies,
            keys: &self.keys,
            joints: &self.joints,
            proxy_len: self.proxy_len(),
            joint_len: self.joint_len,
            fixed: &self.fixed,
            anchors: Some(anchors),
        }
    }

    /// Fits a predictor to every key.
    pub(crate) fn predictors(&self, examples: &Examples) -> Vec<GradientPredictor> {
        let parents = &examples.skeleton.parents;
        let fit = |d: &Vec<_>| {
            GradientPredictor::fit(&self.training.poses, parents, d, Method::Unrefined)
        };
        self.sequences.iter().map(fit).collect()
    }

    /// Moves every vertex by its blended transform.
    pub(crate) fn skin(&self, transforms: &[Matrix3x4<f64>]) -> Vec<Vector3<f64>> {
        let position = |v: usize| {
            let blended: Matrix3x4<f64> =
                self.proxies.of(v).map(|(l, weight)| transforms[l] * weight).sum();
            blended * homogeneous(&self.training.rest[v])
        };
        (0..self.training.rest.len()).map(position).collect()
    }
}

/// Moves every frame by its own rigid motion, joints and mesh together.
pub(crate) fn moved_examples(examples: &Examples) -> (Examples, Vec<Matrix3x4<f64>>) {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let near = examples.diagonal() / 50.0;
    let motions: Vec<_> =
        (0..examples.frame_len()).map(|_| rigid_motion(near, &mut random)).collect();
    let mut moved = examples.clone();
    let (vertex_len, joint_len) = (examples.vertex_len(), examples.joint_len());
    for (at, vertex) in moved.vertices.iter_mut().enumerate() {
        *vertex = (motions[at / vertex_len] * homogeneous(vertex)).into();
    }
    for (at, transform) in moved.transforms.iter_mut().enumerate() {
        *transform = to_rows(&after(&motions[at / joint_len], &from_rows(transform)));
    }
    (moved, motions)
}
