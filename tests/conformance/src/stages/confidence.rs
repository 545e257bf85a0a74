//! Stage confidence of rotational models, on the rotations of stage gradients.

use super::gradients::{exact_rotations, gradients_of};
use super::polar::split_of;
use crate::backend::{Backend, Failure, part};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact};

/// Compares the confidences.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (rotations, n) = (gradients_of(&Cpu, subject)?.rotations, subject.poses.len());
    let split = split_of(&Cpu, subject)?;
    let run = |backend: &dyn Backend| {
        let mut out = vec![POISON; n];
        let inputs = subject.inputs();
        backend.confidence(&subject.loaded, inputs, &rotations, &split, &mut out).map(|()| out)
    };
    let (found, cpu) = (run(backend)?, run(&Cpu)?);
    let mut confidences = Finding::new("confidence");
    for (i, pose) in subject.poses.iter().enumerate() {
        let pose = Inexact::exact(pose.widened());
        let given = exact_rotations(part(&rotations, n, i));
        let expected = tolerance::confidence(&subject.oracle, &pose, &given, backend.arithmetic());
        confidences.compare(&found[i..=i], &cpu[i..=i], &expected.value, &expected.error);
    }
    Ok(vec![confidences])
}
