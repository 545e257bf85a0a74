//! The correction, on the features and the base that the stages before it gave.

use crate::Subject;
use crate::features::features_of;
use crate::gradients::gradients_of;
use crate::palette::{maps_within, palette_on};
use conformance::backend::{Backend, Cpu, poisoned_palette};
use conformance::compare::{Mismatch, within};
use conformance::models::{self, shape_of};
use conformance::poses::{poses, widened};
use conformance::tolerance::{self, Inexact};
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, Matrix3x4};

/// Largest ratios: maps, confidence.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 2], Mismatch> {
    let Subject { envelope, poses, .. } = subject;
    let mut worst = [0.0_f64; 2];
    for pose in poses {
        let features = features_of(backend, envelope, &pose.maps);
        let base = base_of(backend, envelope, &pose.maps);
        let (ratios, _) = one(backend, subject, &pose.maps, &features, base)?;
        worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
    }
    Ok(worst)
}

/// Evaluates what a correction adds to.
pub(crate) fn base_of(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
) -> Vec<Matrix3x4> {
    if envelope.predictor().reconstructs() {
        let input = gradients_of(backend, envelope, pose);
        return palette_on(backend, envelope, pose, &input);
    }
    let mut base = poisoned_palette(envelope);
    backend.joints(envelope, pose, &mut base).expect("the pose is finite");
    base
}

/// The ratios of one correction, and the confidence in it.
fn one(
    backend: &impl Backend,
    subject: &Subject<'_>,
    pose: &[Matrix3x4],
    features: &[Matrix3x4],
    base: Vec<Matrix3x4>,
) -> Result<([f64; 2], f32), Mismatch> {
    let Subject { envelope, oracle, .. } = subject;
    let exact = |maps: &[Matrix3x4]| Inexact::exact(maps.iter().map(widened).collect());
    let (palette, confidence) =
        tolerance::correction(oracle, &exact(pose), &exact(features), exact(&base));
    let mut found = base;
    let run = backend.correction(envelope, pose, features, &mut found);
    let found_confidence = run.expect("the lengths are right");
    let maps = if found.is_empty() { 0.0 } else { maps_within(&found, &palette)? };
    let ratio = within(&[found_confidence], &confidence.value, &confidence.error)?;
    Ok(([maps, ratio], found_confidence))
}

/// What the maps alone give, without a base and a turn that would cover their errors: of the first
/// group each latent value by itself. At most 0.34 of the maps' bounds is reached,
/// and 0.50 of the confidence's.
#[test]
fn a_hundred_thousand_poses_are_within_the_bound() {
    for predictor in [Predictor::Kernel, Predictor::Hybrid] {
        let bytes = models::random(shape_of(predictor));
        let subject = Subject::new("random", &bytes, 0);
        let envelope = &subject.envelope;
        let poses = poses(envelope, 100_000);
        let still = vec![[[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]]; 6];
        let run = |poses: &[conformance::poses::Pose]| {
            let (mut worst, mut counts) = ([0.0_f64; 2], [0; 3]);
            for pose in poses {
                let features = features_of(&Cpu, envelope, &pose.maps);
                let nothing = vec![[[0.0; 4]; 3]; envelope.palette_len()];
                let result = one(&Cpu, &subject, &still, &features, nothing);
                let (ratios, confidence) =
                    result.unwrap_or_else(|mismatch| panic!("{pose:?}: {mismatch:?}"));
                worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
                counts[if confidence == 0.0 { 0 } else { 1 + usize::from(confidence == 1.0) }] += 1;
            }
            (worst, counts)
        };
        let (first, second) = poses.split_at(poses.len() / 2);
        let halves = std::thread::scope(|scope| {
            let other = scope.spawn(|| run(second));
            [run(first), other.join().expect("the other half is within the bound as well")]
        });
        for (worst, counts) in halves {
            println!("{predictor:?}: {worst:.3?} of the bounds; none, some, all: {counts:?}");
            assert!(counts.iter().all(|&count| count > 2_000), "{counts:?}");
            assert!(worst.iter().all(|&ratio| ratio > 0.1), "a bound without use: {worst:?}");
        }
    }
}
