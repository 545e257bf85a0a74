//! The envelope without reduction: one predictor per triangle, and every vertex reconstructed (S3
//! §1, §2; METHOD §1.4 to §1.6). Too slow at run time; the reduction is compared with it.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_trainer::Error;
use sinew_trainer::envelope::lbs::blend::Weights;
use sinew_trainer::envelope::lbs::poses::{Poses, trajectories};
use sinew_trainer::envelope::lbs::weights::{self, BASELINE_INFLUENCES};
use sinew_trainer::envelope::s3::Method;
use sinew_trainer::envelope::s3::keys::GradientPredictor;
use sinew_trainer::envelope::s3::poisson::{Poisson, floating};
use sinew_trainer::envelope::s3::surface::gradient;
use sinew_trainer::envelope::s3::validation::near_rigid;
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::numeric::affine::from_rows;

/// Predictors of the T triangles, and a factored reconstruction.
pub(crate) struct Full<'a> {
    examples: &'a Examples,
    predictors: Vec<GradientPredictor>,
    poisson: Poisson,
    joints: Weights,
}

impl<'a> Full<'a> {
    /// Fits the training frames with the given fraction of near-rigid vertices. Each part of the mesh without a
    /// near-rigid vertex gets one.
    ///
    /// # Errors
    /// The sparse system of the reconstruction could not be factored.
    pub(crate) fn fit(examples: &'a Examples, near_rigid_fraction: f64) -> Result<Self, Error> {
        let triangles = examples.solid_triangles();
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
        while let Some(vertex) = floating(&triangles, &fixed) {
            fixed[vertex] = true;
        }
        let poisson = Poisson::new(rest, &triangles, &fixed)?;
        Ok(Self { examples, predictors, poisson, joints })
    }

    /// Reconstructs the V positions of a frame from its pose.
    pub(crate) fn reconstruct(&self, frame: usize) -> Vec<Vector3<f64>> {
        let poses = Poses::new(self.examples, &[frame]);
        let pose = self.examples.pose(frame);
        let root: Matrix3<f64> = from_rows(&pose[poses.root()]).fixed_columns::<3>(0).into_owned();
        let gradients: Vec<_> =
            self.predictors.iter().map(|predictor| root * predictor.predict(&poses, 0)).collect();
        self.poisson.reconstruct(&gradients, &self.skinned(frame))
    }

    /// Skins the V positions of a frame by LBS.
    pub(crate) fn skinned(&self, frame: usize) -> Vec<Vector3<f64>> {
        let Examples { rest, .. } = self.examples;
        let pose = self.examples.pose(frame);
        let skin = |v| weights::skin(&self.joints, pose, v, &rest[v], &[0.0; 3]).0;
        (0..rest.len()).map(skin).collect()
    }

    /// Returns the RMS error of `skin` over the held-out frames, for example of [`Self::reconstruct`].
    pub(crate) fn rms(&self, skin: impl Fn(&Self, usize) -> Vec<Vector3<f64>>) -> f64 {
        let held_out = self.examples.frames_of(Split::HeldOut);
        let squared = |&frame: &usize| -> f64 {
            let pairs = skin(self, frame).into_iter().zip(self.examples.frame(frame));
            pairs.map(|(y, truth)| (y - Vector3::from(*truth)).norm_squared()).sum()
        };
        let sum: f64 = held_out.iter().map(squared).sum();
        (sum / (held_out.len() * self.examples.vertex_len()) as f64).sqrt()
    }
}
