//! Stage confidence of rotational models, on the rotations of stage gradients.

use super::gradients::{exact_rotations, gradients_of};
use crate::backend::{Backend, Failure, part};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance;

/// Compares the confidences.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (rotations, n) = (gradients_of(&Cpu, subject)?.rotations, subject.poses.len());
    let run = |backend: &dyn Backend| {
        let mut out = vec![POISON; n];
        backend.confidence(&subject.loaded, &rotations, &mut out).map(|()| out)
    };
    let (found, cpu) = (run(backend)?, run(&Cpu)?);
    let mut confidences = Finding::new("confidence");
    for i in 0..n {
        let given = exact_rotations(part(&rotations, n, i));
        let expected = tolerance::confidence(&subject.oracle, &given, backend.arithmetic());
        confidences.compare(&found[i..=i], &cpu[i..=i], &expected.value, &expected.error);
    }
    Ok(vec![confidences])
}
