//! From pose to skin, with the stages' tolerances chained.

use super::gradients::compare_transforms;
use super::gradients::gradients_of;
use super::skin::{self, Skinned, findings, whole_of};
use crate::backend::{Backend, Failure, part};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::poses::{Kind, Pose, rigid_motion, rounded};
use crate::subject::Subject;
use crate::tolerance::{self, EXACT, Inexact, Transform, UNDERFLOW};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_gpu::layout::SkinBatch;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::envelope::oracle;
use sinew_trainer::numeric::affine::after;

/// Compares palettes, confidences, positions, normals and tangents.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let poses: Vec<_> = subject.poses.iter().map(|pose| Inexact::exact(pose.widened())).collect();
    compare(backend, subject, &poses)
}

/// Moves poses by rigid motions, then rounds them, and compares palettes, confidences and skins
/// with the oracle at the unrounded poses.
///
/// # Errors
/// The backend's error.
///
/// # Panics
/// If the oracle itself is not equivariant.
pub fn equivariance(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let diagonal = f64::from(subject.loaded.envelope.certificate().diagonal);
    let (mut carried, mut exact) = (Vec::new(), Vec::new());
    for pose in &subject.poses {
        let motion = rigid_motion(diagonal, &mut random);
        let moved: Vec<_> =
            pose.widened().iter().map(|transform| after(&motion, transform)).collect();
        oracle_is_equivariant(&subject.oracle, pose, &motion, &moved);
        carried.push(Pose { transforms: moved.iter().map(rounded).collect(), ..pose.clone() });
        exact.push(Inexact::rounded(moved));
    }
    compare(backend, &Subject::with_poses(subject.name, subject.loaded, carried), &exact)
}

/// Compares the skin of the rest pose with the rest positions, allowing for the rounding of c1, c2
/// and the weights.
///
/// # Errors
/// The backend's error.
///
/// # Panics
/// If the first pose is not the rest pose.
pub fn rest(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    assert_eq!(subject.poses[0].kind, Kind::Rest);
    let (n, skin) = (subject.poses.len(), SkinBatch::new(&subject.loaded.skin));
    let positions = |backend: &dyn Backend| {
        Ok::<_, Failure>(Skinned::gather(&whole_of(backend, subject)?.skin, &skin, n).positions)
    };
    let (found, cpu) = (positions(backend)?, positions(&Cpu)?);
    let expected = subject.skin.rest_positions.as_flattened();
    let bounds = tolerance::rest(&subject.oracle, &subject.skin);
    let tolerances: Vec<_> = bounds.iter().flat_map(|e| e.iter().map(|e| e + UNDERFLOW)).collect();
    let mut rest = Finding::new("rest");
    rest.compare(part(&found, n, 0), part(&cpu, n, 0), expected, &tolerances);
    Ok(vec![rest])
}

/// Compares the subject's poses with the oracle at their exact values.
fn compare(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    exact: &[Inexact<Transform>],
) -> Result<Vec<Finding>, Failure> {
    let (envelope, n) = (&subject.loaded.envelope, subject.poses.len());
    let rotations = if envelope.predictor().reconstructs() {
        gradients_of(backend, subject)?.rotations
    } else {
        Vec::new()
    };
    let layout = SkinBatch::new(&subject.loaded.skin);
    let (found, cpu) = (whole_of(backend, subject)?, whole_of(&Cpu, subject)?);
    let skins = [&found, &cpu].map(|whole| Skinned::gather(&whole.skin, &layout, n));
    let [mut palette, mut certain] = ["palette", "confidence"].map(Finding::new);
    let mut attributes = findings(&subject.loaded.skin);
    for (i, pose) in exact.iter().enumerate() {
        let (rotations, arithmetic) = (part(&rotations, n, i), backend.arithmetic());
        let curves = subject.poses[i].widened_curves();
        let (expected, confidence) =
            tolerance::whole(&subject.oracle, pose, &curves, rotations, arithmetic);
        let transforms = (part(&found.palettes, n, i), part(&cpu.palettes, n, i));
        compare_transforms(&mut palette, transforms.0, transforms.1, &expected);
        let confidences = (&found.confidences[i..=i], &cpu.confidences[i..=i]);
        certain.compare(confidences.0, confidences.1, &confidence.value, &confidence.error);
        let [found, cpu] = skins.each_ref().map(|skin| skin.at(n, i));
        skin::compare(&mut attributes, (&found, &cpu), subject, &expected, arithmetic);
    }
    Ok([palette, certain].into_iter().chain(attributes).collect())
}

/// Asserts that the oracle is equivariant, which is exact without rounding to f32. Skips half turns,
/// where f64 rounds too, and poses without joints, which no motion moves.
fn oracle_is_equivariant(
    oracle: &EnvelopeModel,
    pose: &Pose,
    motion: &Transform,
    moved: &[Transform],
) {
    if pose.kind == Kind::HalfTurn || pose.transforms.is_empty() {
        return;
    }
    let curves = &pose.widened_curves()[..];
    let (still, confidence) = oracle.evaluate(oracle::Pose { joints: &pose.widened(), curves });
    let (carried, same) = oracle.evaluate(oracle::Pose { joints: moved, curves });
    // Confidence and transforms are differences of large sums, so their errors exceed EXACT.
    assert!((confidence - same).abs() <= 1e3 * EXACT, "{confidence} {same}");
    for (transform, still) in carried.iter().zip(&still) {
        let expected = after(motion, still);
        assert!(
            (transform - expected).amax() <= EXACT * expected.amax().max(transform.amax()).max(1e3)
        );
    }
}
