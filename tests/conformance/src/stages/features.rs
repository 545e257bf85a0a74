//! Stage features, of models with a correction.

use super::gradients::compare_transforms;
use crate::backend::{Backend, Failure, part, poisoned_transforms};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact};
use sinew_runtime::Matrix3x4;

/// Compares the features.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (found, cpu) = (features_of(backend, subject)?, features_of(&Cpu, subject)?);
    let n = subject.poses.len();
    let mut features = Finding::new("features");
    for (i, pose) in subject.poses.iter().enumerate() {
        let expected = Inexact::exact(pose.widened());
        let expected = tolerance::features(&subject.oracle, &expected, backend.arithmetic());
        compare_transforms(&mut features, part(&found, n, i), part(&cpu, n, i), &expected);
    }
    Ok(vec![features])
}

/// Evaluates the features of every pose.
///
/// # Errors
/// The backend's error.
pub fn features_of(
    backend: &dyn Backend,
    subject: &Subject<'_>,
) -> Result<Vec<Matrix3x4>, Failure> {
    let mut out = poisoned_transforms(subject.transforms.len());
    backend.features(&subject.loaded, &subject.transforms, &mut out)?;
    Ok(out)
}
