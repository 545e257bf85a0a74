//! From pose to palette, all stages of a predictor.

use super::confidence::confidence;
use super::correction::correction;
use super::features::features;
use super::gradients::{gradients, relative, rotations, same_branch};
use super::inexact::{Inexact, Transform};
use super::joints::joints;
use super::palette::palette;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::regression::arithmetic::Arithmetic;

/// The whole way from a pose to the palette and the confidence, beside a backend's own rotations,
/// which decide what joints at a half turn do; the kernel predictor has none.
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
