//! The envelope without reduction: one predictor a triangle, every vertex reconstructed (S3 §1, §2;
//! METHOD §1.4 to §1.6). Too slow for run time; it is what the reduction is measured against.

use super::gradient::gradient;
use super::options::Method;
use super::poisson::{Poisson, PoissonError};
use super::predictor::GradientPredictor;
use super::settings::near_rigid;
use crate::envelope::FitError;
use crate::envelope::skin::blend::Weights;
use crate::envelope::skin::poses::{Poses, trajectories};
use crate::envelope::skin::weights::{self, BASELINE_INFLUENCES};
use crate::examples::{Examples, Split};
use crate::numeric::affine::from_rows;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// T predictors and a factored reconstruction.
pub struct Full<'a> {
    examples: &'a Examples,
    predictors: Vec<GradientPredictor>,
    poisson: Poisson,
    joints: Weights,
}

impl<'a> Full<'a> {
    /// Fits the training frames with the given fraction of near-rigid vertices; of each part of the
    /// mesh that has none, one vertex is added to them.
    ///
    /// # Errors
    /// [`FitError::NoTriangles`] and [`FitError::Poisson`].
    pub fn fit(examples: &'a Examples, near_rigid_fraction: f64) -> Result<Self, FitError> {
        let triangles = examples.solid_triangles();
        if triangles.is_empty() {
            return Err(FitError::NoTriangles);
        }
        let frames = examples.frames_of(Split::Train);
        let poses = Poses::new(examples, &frames);
        let moved = trajectories(examples, &frames, &poses);
        let rest = &examples.rest;
        let (joints, errors) = weights::fit(rest, &moved, &poses, BASELINE_INFLUENCES, None);
        let predictors = triangles
            .par_iter()
            .map(|corners| {
                let posed = corners.map(|v| moved.col_as_slice(v).as_chunks::<3>().0);
                let gradients: Vec<_> = (0..frames.len())
                    .filter_map(|i| gradient(corners.map(|v| &rest[v]), posed.map(|y| &y[i])))
                    .collect();
                let parents = &examples.skeleton.parents;
                GradientPredictor::fit(&poses, parents, &gradients, Method::Unrefined)
            })
            .collect();
        let mut fixed = near_rigid(&errors, near_rigid_fraction);
        let poisson = loop {
            match Poisson::new(rest, &triangles, &fixed) {
                Err(PoissonError::Floating { vertex }) => fixed[vertex] = true,
                other => break other?,
            }
        };
        Ok(Self { examples, predictors, poisson, joints })
    }

    /// Reconstructs V positions of a frame from its pose alone.
    pub fn reconstruct(&self, frame: usize) -> Vec<Vector3<f64>> {
        let poses = Poses::new(self.examples, &[frame]);
        let pose = self.examples.pose(frame);
        let root: Matrix3<f64> = from_rows(&pose[poses.root()]).fixed_columns::<3>(0).into_owned();
        let gradients: Vec<_> =
            self.predictors.iter().map(|predictor| root * predictor.predict(&poses, 0)).collect();
        let skinned: Vec<_> = (0..self.examples.vertex_len())
            .map(|v| weights::skin(&self.joints, pose, v, &self.examples.rest[v], &[0.0; 3]).0)
            .collect();
        self.poisson.reconstruct(&gradients, &skinned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::demo::{DemoOptions, demo};

    #[test]
    fn an_arm_is_reconstructed_from_poses_that_were_not_seen() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 60, held_out: 20, seed: 1 });
        let full = Full::fit(&examples, 0.25).unwrap();
        let rms = |skin: &dyn Fn(usize) -> Vec<Vector3<f64>>| {
            let held_out = examples.frames_of(Split::HeldOut);
            let sum: f64 = held_out
                .iter()
                .flat_map(|&frame| skin(frame).into_iter().zip(examples.frame(frame)))
                .map(|(y, truth)| (y - Vector3::from(*truth)).norm_squared())
                .sum();
            (sum / (held_out.len() * examples.vertex_len()) as f64).sqrt()
        };
        let lbs = rms(&|frame| {
            let (pose, rest) = (examples.pose(frame), &examples.rest);
            let skin = |v| weights::skin(&full.joints, pose, v, &rest[v], &[0.0; 3]).0;
            (0..rest.len()).map(skin).collect()
        });
        let found = rms(&|frame| full.reconstruct(frame));
        assert!(found < 0.5 * lbs, "{found} against {lbs} of LBS");
    }
}
