//! The training meshes that a fit is held against.

use super::blend::Weights;
use crate::examples::Importance;
use crate::numeric::affine::homogeneous;
use crate::numeric::columns;
use faer::Mat;
use rayon::prelude::*;

/// The training meshes, as the palette's vertices.
#[derive(Clone, Copy)]
pub struct Targets<'a> {
    /// V rest positions.
    pub rest: &'a [[f64; 3]],
    /// Their weights on the palette.
    pub weights: &'a Weights,
    /// Their trajectories, 3n x V.
    pub trajectories: &'a Mat<f64>,
    /// How much each vertex counts.
    pub importance: Importance<'a>,
}

impl Targets<'_> {
    /// RMS error over vertices and poses under maps, 3n x 4P.
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

    /// What maps (3n x 4P) leave of the trajectories, 3n x V.
    pub fn residuals(&self, maps: &Mat<f64>) -> Mat<f64> {
        let mut left = self.trajectories.clone();
        columns::fill(&mut left, |vertex, column| {
            let blended = skin(&self.rest[vertex], self.weights, vertex, maps);
            column.iter_mut().zip(blended).for_each(|(y, skinned)| *y -= skinned);
        });
        left
    }
}

/// The trajectory of one vertex under maps, 3n long.
pub fn skin(rest: &[f64; 3], weights: &Weights, vertex: usize, maps: &Mat<f64>) -> Vec<f64> {
    weights.blend(vertex, homogeneous(rest).as_slice(), maps)
}
