//! LBS weights by non-negative least squares (METHOD §1.2): the baseline of every report, and the weights of vertices
//! without helpers.

use super::blend::{Items, Pull, Supports, Weights, fit_weights};
use super::poses::{Poses, local, seen_from};
use super::prior::prior;
use super::targets::{Targets, in_poses};
use crate::envelope::folds::Folds;
use crate::examples::{Examples, Importance, Matrix3x4, Split, spread};
use crate::numeric::affine::{cofactors, from_rows, homogeneous, linear};
use crate::numeric::columns;
use crate::settings::{FEW_VERTICES, TIED};
use faer::Mat;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Influences of a vertex in the baseline, as in most engines.
pub const BASELINE_INFLUENCES: usize = 4;
/// Candidate strengths of the pull to prior weights, in squared diagonals. At strength 1 the motion does not matter.
const STRENGTHS: [f64; 10] = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, FREE];
/// The weakest pull, which decides only where the poses do not.
pub const FREE: f64 = 1e-12;
/// Errors below this RMS in diagonals tie: rounding to single precision is as large.
const EXACT: f64 = 1e-6;

/// Fits at most `most` joint weights a vertex to trajectories (3n x V). Returns the weights and the squared error of
/// each vertex, summed over the poses.
///
/// - `pull`: prior weights, J x V, and the strength of the pull to prior weights, in squared units of the trajectories.
///   With `None` only the poses decide.
pub fn fit(
    rest: &[[f64; 3]],
    trajectories: &Mat<f64>,
    poses: &Poses,
    most: usize,
    pull: Option<(&Mat<f64>, f64)>,
) -> (Weights, Vec<f64>) {
    let joints: Vec<usize> = (0..poses.joint_len()).collect();
    let pull = pull.map(|(to, strength)| {
        let strength = strength * poses.len() as f64;
        Pull { to, joints: &joints, strength }
    });
    let items = Items { pull, ..Items::vertices(rest, trajectories, Importance::UNIFORM) };
    fit_weights(&items, &poses.stacked(), Supports::Free(most))
}

/// Linear blend skinning: the baseline of every report, and the weights of vertices without helpers.
pub struct Lbs {
    /// At most [`BASELINE_INFLUENCES`] joint weights a vertex.
    pub weights: Weights,
    /// Squared error of each vertex, summed over the poses.
    pub errors: Vec<f64>,
    /// Prior weights, J x V.
    pub prior: Mat<f64>,
    /// Strength of the pull to prior weights, in squared diagonals.
    pub strength: f64,
}

impl Lbs {
    /// Fits LBS in training units. Chooses the strength of the pull to prior weights by cross-validation over clips or
    /// runs: the strongest pull wins among those that tie with the best.
    ///
    /// - `rest`: V rest positions.
    /// - `trajectories`: 3n x V.
    /// - `prior`: J x V.
    pub fn new(
        rest: &[[f64; 3]],
        trajectories: &Mat<f64>,
        (poses, folds): (&Poses, &Folds),
        prior: Mat<f64>,
    ) -> Self {
        let blocks = folds.clips_or_runs();
        let vertices = spread(rest.len(), FEW_VERTICES);
        let few: Vec<_> = vertices.iter().map(|&v| rest[v]).collect();
        let [moved, few_prior] = [trajectories, &prior].map(|all| columns::some(all, &vertices));
        let errors = blocks.par_iter().map(|block| {
            let others = block.others(poses.len());
            let [seen, unseen] = [&others, &block.own].map(|own| in_poses(&moved, own));
            let [seen_poses, unseen_poses] = [&others, &block.own].map(|own| poses.only(own));
            STRENGTHS.map(|strength| {
                let pull = Some((&few_prior, strength));
                let (weights, _) = fit(&few, &seen, &seen_poses, BASELINE_INFLUENCES, pull);
                let importance = Importance::UNIFORM;
                let targets =
                    Targets { rest: &few, weights: &weights, trajectories: &unseen, importance };
                targets.residuals(&unseen_poses.stacked()).squared_norm_l2()
            })
        });
        let errors: Vec<_> = errors.collect();
        let sums: [f64; STRENGTHS.len()] =
            std::array::from_fn(|k| errors.iter().map(|of_block| of_block[k]).sum());
        let counted = vertices.len() * blocks.iter().map(|block| block.own.len()).sum::<usize>();
        let exact = EXACT.powi(2) * counted as f64;
        let least = sums.into_iter().fold(f64::INFINITY, f64::min).max(exact);
        let strongest = sums.iter().position(|&sum| sum <= TIED.powi(2) * least);
        let strength = STRENGTHS[strongest.unwrap_or(0)];
        Self::pulled(rest, trajectories, poses, (prior, strength))
    }

    /// Fits LBS with the given prior weights and strength of the pull.
    pub fn pulled(
        rest: &[[f64; 3]],
        trajectories: &Mat<f64>,
        poses: &Poses,
        (prior, strength): (Mat<f64>, f64),
    ) -> Self {
        let pull = Some((&prior, strength));
        let (weights, errors) = fit(rest, trajectories, poses, BASELINE_INFLUENCES, pull);
        Self { weights, errors, prior, strength }
    }
}

/// Fits the weights of the baseline to the training frames of the examples.
pub fn baseline(examples: &Examples) -> Weights {
    let frames = examples.frames_of(Split::Train);
    let space = (examples.centroid(), examples.diagonal());
    let rest: Vec<_> = examples.rest.iter().map(|x| local(x, space)).collect();
    let (poses, trajectories) = seen_from(examples, &frames, space);
    Lbs::new(&rest, &trajectories, (&poses, &Folds::new(&poses)), prior(examples, &poses)).weights
}

/// Skins one vertex by LBS: position, and normal by the cofactors of the blended transform.
pub fn skin(
    weights: &Weights,
    pose: &[Matrix3x4],
    vertex: usize,
    rest: &[f64; 3],
    normal: &[f64; 3],
) -> (Vector3<f64>, Vector3<f64>) {
    let blended: nalgebra::Matrix3x4<f64> =
        weights.of(vertex).map(|(joint, weight)| from_rows(&pose[joint]) * weight).sum();
    let cofactors = cofactors(&linear(&blended));
    (blended * homogeneous(rest), cofactors * Vector3::from(*normal))
}
