//! Maps of all poses, stacked: 3n x 4P.

use faer::Mat;
use nalgebra::Matrix3x4;

/// The map of a helper in a pose of stacked maps.
pub fn map_of(maps: &Mat<f64>, pose: usize, helper: usize) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|r, c| maps[(3 * pose + r, 4 * helper + c)])
}

/// The maps in some of the poses: 3 rows of each.
pub fn in_poses(maps: &Mat<f64>, poses: &[usize]) -> Mat<f64> {
    Mat::from_fn(3 * poses.len(), maps.ncols(), |row, column| {
        maps[(3 * poses[row / 3] + row % 3, column)]
    })
}

/// Writes the map of a helper in a pose of stacked maps.
pub fn set_map(maps: &mut Mat<f64>, pose: usize, helper: usize, map: &Matrix3x4<f64>) {
    for c in 0..4 {
        for r in 0..3 {
            maps[(3 * pose + r, 4 * helper + c)] = map[(r, c)];
        }
    }
}

/// The maps of the given joints: 3n x 4P from 3n x 4J.
pub fn bases(stacked: &Mat<f64>, dominant: &[usize]) -> Mat<f64> {
    Mat::from_fn(stacked.nrows(), 4 * dominant.len(), |row, column| {
        stacked[(row, 4 * dominant[column / 4] + column % 4)]
    })
}
