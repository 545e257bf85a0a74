//! Stage correction, on the features and the base palettes of the stages before.

use super::features::features_of;
use super::gradients::gradients_of;
use super::gradients::{compare_transforms, exact};
use super::joints::joints_of;
use super::palette::palettes_on;
use crate::backend::{Backend, Failure, Poses, part};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact};
use sinew_runtime::Matrix3x4;

/// Compares transforms and confidences.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (features, base) = (features_of(&Cpu, subject)?, base_of(&Cpu, subject)?);
    Ok(on(backend, subject, subject.inputs(), &features, &base)?.0.into())
}

/// Evaluates the base palettes, before the correction.
///
/// # Errors
/// The backend's error.
pub fn base_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Matrix3x4>, Failure> {
    if subject.oracle.predictor().reconstructs() {
        return palettes_on(backend, subject, &gradients_of(backend, subject)?);
    }
    joints_of(backend, subject)
}

/// Converts floats to exact values.
pub fn exact_floats(floats: &[f32]) -> Inexact<f64> {
    let value = floats.iter().map(|x| f64::from(*x)).collect();
    Inexact { value, error: vec![0.0; floats.len()] }
}

/// Compares the corrections for any poses, features and base palettes; also returns the confidences
/// found.
///
/// # Errors
/// The backend's error.
pub fn on(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    poses: Poses<'_>,
    features: &[f32],
    base: &[Matrix3x4],
) -> Result<([Finding; 2], Vec<f32>), Failure> {
    let n = poses.len;
    let run = |backend: &dyn Backend| {
        let (mut palettes, mut confidences) = (base.to_vec(), vec![POISON; n]);
        let (out, out_confidences) = (&mut palettes, &mut confidences);
        backend.correction(&subject.loaded, poses, features, out, out_confidences)?;
        Ok::<_, Failure>((palettes, confidences))
    };
    let ((found, certain), (cpu, cpu_certain)) = (run(backend)?, run(&Cpu)?);
    let [mut transforms, mut confidences] = ["correction", "confidence"].map(Finding::new);
    for i in 0..n {
        let (pose, features) = (exact(poses.one(i).joints), exact_floats(part(features, n, i)));
        let base = exact(part(base, n, i));
        let arithmetic = backend.arithmetic();
        let (expected, confidence) =
            tolerance::correction(&subject.oracle, &pose, &features, base, arithmetic);
        compare_transforms(&mut transforms, part(&found, n, i), part(&cpu, n, i), &expected);
        let (found, cpu) = (&certain[i..=i], &cpu_certain[i..=i]);
        confidences.compare(found, cpu, &confidence.value, &confidence.error);
    }
    Ok(([transforms, confidences], certain))
}
