//! LBS weights by non-negative least squares (METHOD §1.2): the near-rigid vertices' skinning and
//! the baseline that every report compares with.

use super::blend::{Items, Maps, Supports, Weights, fit_weights};
use super::bones;
use super::poses::{Poses, local, seen_from};
use crate::examples::{Examples, Importance, Matrix3x4, Split};
use crate::numeric::affine::{cofactors, from_rows, homogeneous, linear};
use faer::Mat;
use nalgebra::Vector3;

/// Influences of the baseline, as most engines skin.
pub const BASELINE_INFLUENCES: usize = 4;

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

/// Fits the baseline's weights to the training frames of examples.
pub fn baseline(examples: &Examples) -> Weights {
    let frames = examples.frames_of(Split::Train);
    let centroid = (examples.centroid(), 1.0);
    let rest: Vec<_> = examples.rest.iter().map(|x| local(x, centroid)).collect();
    let (poses, moved) = seen_from(examples, &frames, centroid);
    let farther = bones::farther(examples, &poses);
    fit(&rest, &moved, &poses, BASELINE_INFLUENCES, Some(&farther)).0
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
