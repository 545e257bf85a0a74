//! Fit of helper transforms of a kind, which bones hold (METHOD §1.13).

use crate::envelope::lbs::blend::Normal;
use crate::envelope::lbs::targets::{map_of, set_map};
use crate::numeric::trs::{Place, nearest};
use faer::Mat;
use nalgebra::{Matrix3x4, Matrix4, Vector3};
use rayon::prelude::*;
use sinew_runtime::envelope::HelperKind;

/// Fits helper transforms of a kind to normal equations, starting from given transforms. Both are 3n x 4P, or on a basis
/// of n poses.
///
/// In a sweep each helper in turn takes a transform of the kind near to its best affine one, with the others fixed. No
/// sweep raises the squared error.
///
/// - `basis`: vectors of the basis, 3n x r; `None` if the rows are poses.
pub(super) fn fit_kind(
    normal: &Normal,
    start: &Mat<f64>,
    kind: HelperKind,
    basis: Option<&Mat<f64>>,
    sweeps: usize,
) -> Mat<f64> {
    let in_poses = |own: Mat<f64>| basis.map_or_else(|| own.clone(), |basis| basis * &own);
    let mut maps = start.clone();
    for _ in 0..sweeps {
        for l in 0..start.ncols() / 4 {
            let gram = Matrix4::from_fn(|r, c| normal.gram[(4 * l + r, 4 * l + c)]);
            let Some(inverse) = gram.try_inverse() else { continue };
            let slope = normal.right.subcols(4 * l, 4) - &maps * normal.gram.subcols(4 * l, 4);
            let last = maps.subcols(4 * l, 4).to_owned();
            let free = &last + slope * Mat::from_fn(4, 4, |r, c| inverse[(r, c)]);
            let (free, last) = (in_poses(free), in_poses(last));
            let Some(place) = Place::new(&gram, f64::EPSILON) else { continue };
            let of_pose = |pose| {
                let last = map_of(&last, pose, 0);
                let scale = match kind {
                    HelperKind::Trs => Vector3::from_fn(|axis, _| last.column(axis).norm()),
                    _ => Vector3::repeat(1.0),
                };
                nearest(kind, &map_of(&free, pose, 0), &scale, &place)
            };
            let all: Vec<Matrix3x4<f64>> =
                (0..free.nrows() / 3).into_par_iter().map(of_pose).collect();
            let mut own = free;
            all.iter().enumerate().for_each(|(pose, map)| set_map(&mut own, pose, 0, map));
            let own = basis.map_or_else(|| own.clone(), |basis| basis.transpose() * &own);
            maps.subcols_mut(4 * l, 4).copy_from(own);
        }
    }
    maps
}
