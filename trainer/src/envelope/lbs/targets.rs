//! Training meshes as targets of a fit, and palettes of all poses: stacked matrices of 3n x 4P.

use super::blend::Weights;
use crate::examples::Importance;
use crate::numeric::affine::homogeneous;
use crate::numeric::columns;
use faer::Mat;
use nalgebra::Matrix3x4;
use rayon::prelude::*;

/// Trajectories of vertices and their weights on a palette.
#[derive(Clone, Copy)]
pub struct Targets<'a> {
    /// V rest positions.
    pub rest: &'a [[f64; 3]],
    /// Weights of the vertices on the palette.
    pub weights: &'a Weights,
    /// Trajectories of the vertices, 3n x V.
    pub trajectories: &'a Mat<f64>,
    /// Importance of each vertex.
    pub importance: Importance<'a>,
}

impl Targets<'_> {
    /// Returns the RMS error of a palette over vertices and poses.
    ///
    /// - `maps`: 3n x 4P.
    pub fn rms(&self, maps: &Mat<f64>) -> f64 {
        let errors: Vec<f64> = (0..self.rest.len())
            .into_par_iter()
            .map_init(columns::narrow_registers, |(), vertex| {
                let blended = skin(&self.rest[vertex], self.weights, vertex, maps);
                let truth = self.trajectories.col_as_slice(vertex);
                let error: f64 = blended.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
                self.importance.of(vertex) * error
            })
            .collect();
        (errors.iter().sum::<f64>() / (self.rest.len() * maps.nrows() / 3).max(1) as f64).sqrt()
    }

    /// Returns trajectories minus skinned positions, 3n x V.
    ///
    /// - `maps`: 3n x 4P.
    pub fn residuals(&self, maps: &Mat<f64>) -> Mat<f64> {
        let mut residuals = self.trajectories.clone();
        columns::fill(&mut residuals, |vertex, column| {
            let blended = skin(&self.rest[vertex], self.weights, vertex, maps);
            column.iter_mut().zip(blended).for_each(|(y, skinned)| *y -= skinned);
        });
        residuals
    }
}

/// Skins one vertex in all poses. Returns its trajectory, 3n numbers.
///
/// - `maps`: 3n x 4P.
pub fn skin(rest: &[f64; 3], weights: &Weights, vertex: usize, maps: &Mat<f64>) -> Vec<f64> {
    weights.blend(vertex, homogeneous(rest).as_slice(), maps)
}

/// Reads the transform of a helper in a pose.
pub fn map_of(maps: &Mat<f64>, pose: usize, helper: usize) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|r, c| maps[(3 * pose + r, 4 * helper + c)])
}

/// Selects some of the poses: 3 rows of each.
pub fn in_poses(maps: &Mat<f64>, poses: &[usize]) -> Mat<f64> {
    Mat::from_fn(3 * poses.len(), maps.ncols(), |row, column| {
        maps[(3 * poses[row / 3] + row % 3, column)]
    })
}

/// Writes the transform of a helper in a pose.
pub fn set_map(maps: &mut Mat<f64>, pose: usize, helper: usize, map: &Matrix3x4<f64>) {
    for c in 0..4 {
        for r in 0..3 {
            maps[(3 * pose + r, 4 * helper + c)] = map[(r, c)];
        }
    }
}

/// Selects the transforms of the given joints: 3n x 4P from 3n x 4J.
pub fn bases(stacked: &Mat<f64>, dominant: &[usize]) -> Mat<f64> {
    Mat::from_fn(stacked.nrows(), 4 * dominant.len(), |row, column| {
        stacked[(row, 4 * dominant[column / 4] + column % 4)]
    })
}
