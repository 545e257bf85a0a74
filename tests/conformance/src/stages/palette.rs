//! Stage palette, on the outputs of stage gradients.

use super::gradients::compare_transforms;
use super::gradients::{columns, gradients_of};
use crate::backend::{Backend, Failure, Gradients, part, poisoned_transforms};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::poses::widened;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact};
use sinew_runtime::Matrix3x4;

/// Compares the transforms.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (root, n) = (subject.oracle.skeleton.root(), subject.poses.len());
    let input = gradients_of(&Cpu, subject)?;
    let (found, cpu) =
        (palettes_on(backend, subject, &input)?, palettes_on(&Cpu, subject, &input)?);
    let mut transforms = Finding::new("palette");
    for (i, pose) in subject.poses.iter().enumerate() {
        let relative = Inexact::exact(columns::<4>(part(&input.relative, n, i)));
        let gradients = Inexact::exact(columns::<3>(part(&input.gradients, n, i)));
        let root = Inexact::exact(vec![widened(&pose.transforms[root])]);
        let expected = tolerance::palette(&subject.oracle, &root, &relative, &gradients);
        compare_transforms(&mut transforms, part(&found, n, i), part(&cpu, n, i), &expected);
    }
    Ok(vec![transforms])
}

/// Evaluates the palettes of every pose from outputs of stage gradients.
///
/// # Errors
/// The backend's error.
pub fn palettes_on(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    input: &Gradients,
) -> Result<Vec<Matrix3x4>, Failure> {
    let mut out = poisoned_transforms(subject.poses.len() * subject.loaded.envelope.palette_len());
    backend.palette(&subject.loaded, subject.inputs(), input, &mut out)?;
    Ok(out)
}
