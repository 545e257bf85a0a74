//! Stage features, of models with a correction.

use super::polar::split_of;
use crate::backend::{Backend, Failure, Split, part};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact, UNDERFLOW};

/// Compares the features.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (split, n) = (split_of(&Cpu, subject)?, subject.poses.len());
    let (found, cpu) =
        (features_on(backend, subject, &split)?, features_on(&Cpu, subject, &split)?);
    let mut features = Finding::new("features");
    for (i, pose) in subject.poses.iter().enumerate() {
        let (given, curves) = (Inexact::exact(pose.widened()), pose.widened_curves());
        let arithmetic = backend.arithmetic();
        let Inexact { value, error } =
            tolerance::features(&subject.oracle, &given, &curves, arithmetic);
        let tolerances: Vec<_> = error.iter().map(|e| e + UNDERFLOW).collect();
        features.compare(part(&found, n, i), part(&cpu, n, i), &value, &tolerances);
    }
    Ok(vec![features])
}

/// Evaluates the features of every pose, after stage polar.
///
/// # Errors
/// The backend's error.
pub fn features_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<f32>, Failure> {
    features_on(backend, subject, &split_of(backend, subject)?)
}

/// Evaluates the features of every pose from outputs of stage polar.
fn features_on(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    split: &Split,
) -> Result<Vec<f32>, Failure> {
    let len = subject.poses.len() * subject.loaded.envelope.counts().feature_len();
    let mut out = vec![POISON; len];
    backend.features(&subject.loaded, subject.inputs(), split, &mut out)?;
    Ok(out)
}
