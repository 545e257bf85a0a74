//! The confidence of rotational models, on the rotations that stage 1 gave.

use crate::Subject;
use crate::gradients::{exact_rotations, gradients_of};
use conformance::backend::Backend;
use conformance::compare::{Mismatch, within};
use conformance::tolerance;

/// Largest ratio.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 1], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    let mut worst = 0.0_f64;
    for pose in poses {
        let rotations = gradients_of(backend, envelope, &pose.maps).rotations;
        let found = backend.confidence(envelope, &rotations).expect("the length is right");
        let expected = tolerance::confidence(oracle, &exact_rotations(&rotations));
        worst = worst.max(within(&[found], &expected.value, &expected.error)?);
    }
    Ok([worst])
}
