//! From pose to palette: all stages of a predictor.

use super::confidence::confidence;
use super::correction::correction;
use super::features::features;
use super::gradients::{gradients, relative, rotations, same_branch};
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
    found: &[[f32; 3]],
    arithmetic: Arithmetic,
) -> (Inexact<Transform>, Inexact<f64>) {
    let corrected =
        |base| correction(oracle, pose, &features(oracle, pose, arithmetic), base, arithmetic);
    if !oracle.predictor().reconstructs() {
        return corrected(joints(oracle, pose));
    }
    let relative = relative(oracle, pose);
    let mut rotations = rotations(oracle, &relative, arithmetic);
    same_branch(&mut rotations, found);
    let gradients = gradients(oracle, &relative, &rotations, arithmetic);
    let root = oracle.skeleton.root();
    let (value, error) = (pose.value[root], pose.error[root]);
    let root = Inexact { value: vec![value], error: vec![error] };
    let palette = palette(oracle, &root, &relative, &gradients);
    if oracle.predictor().corrects() {
        return corrected(palette);
    }
    (palette, confidence(oracle, &rotations, arithmetic))
}
