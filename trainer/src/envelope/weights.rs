//! LBS weights by non-negative least squares (METHOD §1.2): the near-rigid vertices' skinning and
//! the baseline that every report compares with.

use super::blend::{Items, Maps, Weights, fit_weights};
use super::motion::{Poses, to_nalgebra, transform};
use crate::examples::{Importance, Matrix3x4};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// Influences of the baseline, as most engines skin.
pub const BASELINE_INFLUENCES: usize = 4;

/// Fits at most `most` joint weights a vertex to trajectories (3n x V); returns them and the
/// vertices' squared errors, summed over the poses.
pub fn fit(
    rest: &[[f64; 3]],
    trajectories: &Mat<f64>,
    poses: &Poses,
    most: usize,
) -> (Weights, Vec<f64>) {
    let items = Items::vertices(rest, trajectories, Importance::ALIKE);
    fit_weights(&items, &Maps { width: 4, columns: poses.stacked() }, most, None)
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
        weights.of(vertex).map(|(joint, weight)| to_nalgebra(&pose[joint]) * weight).sum();
    let cofactors = cofactors(&blended.fixed_columns::<3>(0).into());
    (transform(&blended, rest), cofactors * Vector3::from(*normal))
}

/// Returns the cofactors of a blended map's linear part, which move normals: the blend shrinks between
/// joints, but they still point outward.
pub fn cofactors(linear: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [0, 1, 2].map(|k| linear.column(k).into_owned());
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}
