//! LBS weights by non-negative least squares (METHOD §1.2): the near-rigid vertices' skinning and
//! the baseline that every report compares with.

use super::blend::{Items, Maps, Supports, Weights, fit_weights};
use super::bones;
use super::painted::Painted;
use super::poses::{Poses, local, seen_from};
use super::targets::Targets;
use crate::constants::ERRS;
use crate::examples::{Examples, Importance, Matrix3x4, Split};
use crate::numeric::affine::{cofactors, from_rows, homogeneous, linear};
use faer::Mat;
use nalgebra::Vector3;

/// Influences of the baseline, as most engines skin.
pub const BASELINE_INFLUENCES: usize = 4;
/// Painted weights with a smaller error, RMS in diagonals, stay as they are: single precision rounds as much.
const EXACT: f64 = 1e-6;

/// Fits at most `most` joint weights a vertex to trajectories (3n x V); returns them and the
/// vertices' squared errors, summed over the poses.
///
/// - `farther`: as [`bones::farther`] gives it, where positions are about the centroid; without, the poses alone tell.
pub fn fit(
    rest: &[[f64; 3]],
    trajectories: &Mat<f64>,
    poses: &Poses,
    most: usize,
    farther: Option<&Mat<f64>>,
) -> (Weights, Vec<f64>) {
    let items = Items { farther, ..Items::vertices(rest, trajectories, Importance::ALIKE) };
    let joints = Maps { width: 4, columns: poses.stacked() };
    fit_weights(&items, &joints, Supports::Free(most))
}

/// Linear blend skinning: the baseline, and what stays where it is right.
pub struct Lbs {
    /// At most [`BASELINE_INFLUENCES`] joint weights a vertex.
    pub weights: Weights,
    /// Squared error of each vertex, summed over the poses.
    pub errors: Vec<f64>,
    /// How many times farther each joint is from each vertex than the nearest, J x V: by the weights that come with the
    /// examples, else by the joints' bones.
    pub farther: Mat<f64>,
    /// Joints on whose skin those weights mislead, so that it goes by bones.
    pub misleading: Vec<usize>,
}

impl Lbs {
    /// Fits LBS to training frames as they are seen: V rest positions, trajectories 3n x V and poses about the centre of
    /// the mesh, in diagonals.
    pub fn new(
        examples: &Examples,
        rest: &[[f64; 3]],
        trajectories: &Mat<f64>,
        poses: &Poses,
    ) -> Self {
        let fit =
            |farther: &Mat<f64>| fit(rest, trajectories, poses, BASELINE_INFLUENCES, Some(farther));
        let by_bones = bones::farther(examples, poses);
        let (weights, errors) = fit(&by_bones);
        let Some(painted) = Painted::of(examples) else {
            return Self { weights, errors, farther: by_bones, misleading: Vec::new() };
        };
        let mut farther = painted.farther(&by_bones);
        let (mut near, mut near_errors) = fit(&farther);
        let unseen = ERRS.get().powi(2) * (trajectories.nrows() / 3) as f64;
        let misleading = painted.misleading(&near_errors, &errors, unseen);
        if !misleading.is_empty() {
            for vertex in (0..rest.len()).filter(|&vertex| painted.follows(vertex, &misleading)) {
                farther.col_mut(vertex).copy_from(by_bones.col(vertex));
            }
            (near, near_errors) = fit(&farther);
        }
        // On a hinge the position of a vertex says nothing of its weights; its normal hangs on them.
        let (own, importance) = (painted.weights(), Importance::ALIKE);
        let targets = Targets { rest, weights: &own, trajectories, importance };
        let left = targets.residuals(&poses.stacked());
        let lists = (0..rest.len()).map(|vertex| {
            let error = left.col(vertex).squared_norm_l2();
            let len = own.of(vertex).count();
            if len == 0 || len > BASELINE_INFLUENCES || error > EXACT * EXACT * poses.len() as f64 {
                return near.of(vertex).collect();
            }
            near_errors[vertex] = error;
            own.of(vertex).collect()
        });
        let near = Weights::from_lists(BASELINE_INFLUENCES, lists);
        Self { weights: near, errors: near_errors, farther, misleading }
    }
}

/// Fits the baseline's weights to the training frames of examples.
pub fn baseline(examples: &Examples) -> Weights {
    let frames = examples.frames_of(Split::Train);
    let seen = (examples.centroid(), examples.diagonal());
    let rest: Vec<_> = examples.rest.iter().map(|x| local(x, seen)).collect();
    let (poses, moved) = seen_from(examples, &frames, seen);
    Lbs::new(examples, &rest, &moved, &poses).weights
}

/// Skins one vertex by LBS: its position and the normal that the blended map's cofactors give.
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
