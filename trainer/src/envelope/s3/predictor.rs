//! The gradient predictor of one sequence: rotation times scale and shear (METHOD §1.5).

use super::gradient::polar_sequence;
use super::options::Method;
use super::rotation::{RotationPredictor, Solver};
use super::scale_shear;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::model::Key;
use faer::Mat;
use nalgebra::{Matrix3, Matrix6};

/// A key, and how every joint would have done in its place.
#[derive(Clone, Debug)]
pub struct GradientPredictor {
    /// `D(q) = Q_p exp(u W θ_b) [exp(u' W' θ_c)] S(q)`.
    pub key: Key,
    /// b's parent.
    pub parent: Option<usize>,
    /// B, which is added to S(q); zero but in a fit as published.
    pub bias: Matrix3<f64>,
    /// Σ|R - R_pred|² of each joint as b, J.
    pub errors: Vec<f64>,
    /// Σ|R - R_pred|² of each joint as c, J; b's own is that without c.
    pub residual_errors: Vec<f64>,
}

impl GradientPredictor {
    /// Fits a predictor to a sequence of gradients relative to the root, one per pose.
    pub fn fit(
        poses: &Poses,
        parents: &[Option<usize>],
        gradients: &[Matrix3<f64>],
        method: Method,
    ) -> Self {
        let published = method == Method::Published;
        let solver = if published { Solver::Alternation } else { Solver::ClosedForm };
        let (rotations, stretches): (Vec<_>, Vec<_>) =
            polar_sequence(gradients).into_iter().unzip();
        let RotationPredictor { joint, twist, residual, errors, residual_errors } =
            RotationPredictor::fit(poses, &rotations, solver);
        let parent = parents[joint];
        let stretches = stretches.into_iter();
        let (shear, bias) = scale_shear::fit(poses, joint, parent, stretches, published);
        Self { key: Key { joint, twist, residual, shear }, parent, bias, errors, residual_errors }
    }

    /// The same without scale and shear.
    #[must_use]
    pub fn without_shear(&self) -> Self {
        let key = Key { shear: Matrix6::zeros(), ..self.key.clone() };
        Self { key, bias: Matrix3::zeros(), ..self.clone() }
    }

    /// Predicts the gradient of a pose, relative to the root.
    pub fn predict(&self, poses: &Poses, pose: usize) -> Matrix3<f64> {
        let parent = *poses.parent_rotation(pose, self.key.joint);
        let mut factors = self.key.factors(parent, |joint| poses.angle(pose, joint), self.parent);
        factors.stretch += self.bias;
        factors.gradient()
    }
}

/// Predicts the gradients of P keys in n poses: 3n x 3P, columns 3l..3l+3 are key l.
pub fn predict_stacked(predictors: &[GradientPredictor], poses: &Poses) -> Mat<f64> {
    let mut out = Mat::zeros(3 * poses.len(), 3 * predictors.len());
    for (l, predictor) in predictors.iter().enumerate() {
        for pose in 0..poses.len() {
            let d = predictor.predict(poses, pose);
            for c in 0..3 {
                let column = &mut out.col_as_slice_mut(3 * l + c)[3 * pose..3 * pose + 3];
                column.copy_from_slice(d.column(c).as_slice());
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::so3;

    #[test]
    fn the_joint_and_the_residual_joint_of_a_made_sequence_are_found() {
        let examples = demo(&DemoOptions { vertices: 200, poses: 80, held_out: 0, seed: 4 });
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let poses = Poses::new(&examples, &frames);
        let ranges = poses.angle_ranges();
        let mut moving: Vec<usize> = (0..poses.joint_len()).filter(|&j| ranges[j] > 0.3).collect();
        let (joint, residual) = (moving.remove(0), moving.remove(0));
        let sequence: Vec<_> = (0..poses.len())
            .map(|i| {
                poses.parent_rotation(i, joint)
                    * so3::exp(&(poses.angle(i, joint) * 0.6))
                    * so3::exp(&(poses.angle(i, residual) * 0.3))
            })
            .collect();
        let parents = &examples.skeleton.parents;
        let fitted = GradientPredictor::fit(&poses, parents, &sequence, Method::Refined);
        let rms = |predicted: &dyn Fn(usize) -> Matrix3<f64>| {
            let sum: f64 =
                (0..poses.len()).map(|i| (predicted(i) - sequence[i]).norm_squared()).sum();
            (sum / poses.len() as f64).sqrt()
        };
        let error = rms(&|i| fitted.predict(&poses, i));
        let mut one_joint = fitted.clone();
        one_joint.key.residual = None;
        let alone = rms(&|i| one_joint.predict(&poses, i));
        assert!(error < 0.5 * alone, "{error} against {alone}");
        let used = [Some(fitted.key.joint), fitted.key.residual.map(|(j, _)| j)];
        assert!(used.contains(&Some(joint)) && used.contains(&Some(residual)), "{used:?}");
        let stacked = predict_stacked(std::slice::from_ref(&fitted), &poses);
        assert_eq!(stacked[(3 * 7 + 1, 2)], fitted.predict(&poses, 7)[(1, 2)]);
    }
}
