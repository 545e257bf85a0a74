//! The pose features of models with a correction.

use crate::Subject;
use crate::palette::maps_within;
use conformance::backend::{Backend, poisoned_features};
use conformance::compare::Mismatch;
use conformance::tolerance::{self, Inexact};
use sinew_runtime::{Envelope, Matrix3x4};

/// Largest ratio of the features.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 1], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    let mut worst = 0.0_f64;
    for pose in poses {
        let found = features_of(backend, envelope, &pose.maps);
        let expected = tolerance::features(oracle, &Inexact::exact(pose.widened()));
        worst = worst.max(maps_within(&found, &expected)?);
    }
    Ok([worst])
}

/// Evaluates the features of a pose.
pub(crate) fn features_of(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
) -> Vec<Matrix3x4> {
    let mut features = poisoned_features(envelope);
    let run = backend.features(envelope, pose, &mut features);
    run.expect("the pose is finite and the lengths are right");
    features
}
