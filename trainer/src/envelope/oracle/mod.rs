//! The f64 oracle of the runtime's stages: evaluates a fitted or loaded model (METHOD §1.1 to §1.9).
//!
//! The oracle uses general matrix routines and shares no code with the runtime's stages. So every stage can be tested
//! against it, alone or from pose to skin.

mod correction;
mod reconstruction;
mod skin;

pub use reconstruction::stack;
pub use skin::MovedVertex;

use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::targets::set_map;
use crate::envelope::model::EnvelopeModel;
use crate::numeric::affine::after;
use faer::Mat;
use nalgebra::Matrix3x4;

/// What moves a skin: J skinning matrices and C curves.
#[derive(Clone, Copy)]
pub struct Pose<'a> {
    /// Skinning matrices, J.
    pub joints: &'a [Matrix3x4<f64>],
    /// Values of the curves, C.
    pub curves: &'a [f64],
}

impl EnvelopeModel {
    /// Evaluates a pose by all stages. Returns the palette and the confidence.
    pub fn evaluate(&self, pose: Pose<'_>) -> (Vec<Matrix3x4<f64>>, f64) {
        let base = self.base(pose.joints);
        if !self.predictor().reconstructs() {
            return self.correct(pose.joints, &self.features(pose), base);
        }
        let confidence = self.confidence(pose.joints, &self.rotations(pose.joints));
        (base, confidence)
    }

    /// Evaluates a pose without the correction. Returns the base palette.
    ///
    /// - `pose`: skinning matrices, J.
    pub fn base(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        if !self.predictor().reconstructs() {
            return self.joints(pose);
        }
        let gradients = self.gradients(pose, &self.rotations(pose));
        self.palette(&pose[self.skeleton.root()], &self.relative(pose), &gradients)
    }

    /// Evaluates n poses without the root's motion. Returns stacked palettes, 3n x 4 per transform.
    pub fn palettes(&self, poses: &Poses) -> Mat<f64> {
        self.stack(poses, |pose| self.evaluate(pose).0)
    }

    /// Evaluates n poses without the root's motion and without the correction. Returns stacked palettes, 3n x 4 per
    /// transform.
    pub fn bases(&self, poses: &Poses) -> Mat<f64> {
        self.stack(poses, |pose| self.base(pose.joints))
    }

    fn stack(&self, poses: &Poses, palette: impl Fn(Pose<'_>) -> Vec<Matrix3x4<f64>>) -> Mat<f64> {
        let mut out = Mat::zeros(3 * poses.len(), 4 * self.palette_len());
        for index in 0..poses.len() {
            let (joints, inverse) = poses.in_model_space(index);
            let pose = Pose { joints: &joints, curves: poses.curves(index) };
            for (l, map) in palette(pose).iter().enumerate() {
                set_map(&mut out, index, l, &after(&inverse, map));
            }
        }
        out
    }
}
