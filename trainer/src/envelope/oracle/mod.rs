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
use faer::Mat;
use nalgebra::Matrix3x4;

impl EnvelopeModel {
    /// Evaluates a pose by all stages. Returns the palette and the confidence.
    ///
    /// - `pose`: skinning matrices, J.
    pub fn evaluate(&self, pose: &[Matrix3x4<f64>]) -> (Vec<Matrix3x4<f64>>, f64) {
        let base = self.base(pose);
        if !self.predictor().reconstructs() {
            return self.correct(pose, &self.features(pose), base);
        }
        let confidence = self.confidence(&self.rotations(&self.relative(pose)));
        (base, confidence)
    }

    /// Evaluates a pose without the correction. Returns the base palette.
    ///
    /// - `pose`: skinning matrices, J.
    pub fn base(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        if !self.predictor().reconstructs() {
            return self.joints(pose);
        }
        let relative = self.relative(pose);
        let gradients = self.gradients(&relative, &self.rotations(&relative));
        self.palette(&pose[self.skeleton.root()], &relative, &gradients)
    }

    /// Evaluates n poses without the root's motion. Returns stacked palettes, 3n x 4 per transform.
    pub fn palettes(&self, poses: &Poses) -> Mat<f64> {
        self.stack(poses, |pose| self.evaluate(pose).0)
    }

    /// Evaluates n poses without the root's motion and without the correction. Returns stacked palettes, 3n x 4 per
    /// transform.
    pub fn bases(&self, poses: &Poses) -> Mat<f64> {
        self.stack(poses, |pose| self.base(pose))
    }

    fn stack(
        &self,
        poses: &Poses,
        palette: impl Fn(&[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>>,
    ) -> Mat<f64> {
        let mut out = Mat::zeros(3 * poses.len(), 4 * self.palette_len());
        for index in 0..poses.len() {
            for (l, map) in palette(poses.pose(index)).iter().enumerate() {
                set_map(&mut out, index, l, map);
            }
        }
        out
    }
}
