//! From pose to palette: all stages of a predictor.

use super::confidence::confidence;
use super::correction::correction;
use super::features::features;
use super::gradients::{gradients, relative, rotations, same_branch, turning};
use super::inexact::{Inexact, Transform};
use super::joints::joints;
use super::palette::palette;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::regression::arithmetic::Arithmetic;

/// Bounds palette and confidence, from a pose through all stages. `found` are the backend's own
/// rotations, which decide the branch of joints at a half turn; the kernel predictor has none.
pub fn whole(
    oracle: &EnvelopeModel,
    pose: &Inexact<Transform>,
    curves: &[f64],
    found: &[[f32; 3]],
    arithmetic: Arithmetic,
) -> (Inexact<Transform>, Inexact<f64>) {
    if !oracle.predictor().reconstructs() {
        let features = features(oracle, pose, curves, arithmetic);
        return correction(oracle, pose, &features, joints(oracle, pose), arithmetic);
    }
    let relative = relative(oracle, pose, arithmetic);
    let turning = turning(oracle, pose, &relative);
    let mut rotations = rotations(oracle, turning, arithmetic);
    same_branch(&mut rotations, found);
    let gradients = gradients(oracle, turning, &rotations, arithmetic);
    let root = oracle.skeleton.root();
    let (value, error) = (pose.value[root], pose.error[root]);
    let root = Inexact { value: vec![value], error: vec![error] };
    let palette = palette(oracle, &root, &relative, &gradients);
    (palette, confidence(oracle, pose, &rotations, arithmetic))
}
