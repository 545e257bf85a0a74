//! From pose to palette.

use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::targets::set_map;
use crate::envelope::model::EnvelopeModel;
use faer::Mat;
use nalgebra::Matrix3x4;

impl EnvelopeModel {
    /// Evaluates a pose of J skinning matrices from end to end: the palette, and the confidence in
    /// it.
    pub fn evaluate(&self, pose: &[Matrix3x4<f64>]) -> (Vec<Matrix3x4<f64>>, f64) {
        if !self.predictor().reconstructs() {
            return self.correct(pose, &self.features(pose), self.joints(pose));
        }
        let relative = self.relative(pose);
        let rotations = self.rotations(&relative);
        let gradients = self.gradients(&relative, &rotations);
        let palette = self.palette(&pose[self.skeleton.root()], &relative, &gradients);
        if self.predictor().corrects() {
            return self.correct(pose, &self.features(pose), palette);
        }
        (palette, self.confidence(&rotations))
    }

    /// Evaluates a pose without the correction: what the palette starts from.
    pub fn base(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        if !self.predictor().reconstructs() {
            return self.joints(pose);
        }
        let relative = self.relative(pose);
        let gradients = self.gradients(&relative, &self.rotations(&relative));
        self.palette(&pose[self.skeleton.root()], &relative, &gradients)
    }

    /// Evaluates n poses without the root's motion: palettes, 3n x 4 a transform.
    pub fn palettes(&self, poses: &Poses) -> Mat<f64> {
        self.stack(poses, |pose| self.evaluate(pose).0)
    }

    /// Evaluates n poses without the root's motion and without the correction, likewise.
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
