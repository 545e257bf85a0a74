//! Stage polar, of models whose joints stretch.

use crate::backend::{Backend, Failure, Split, part};
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::subject::Subject;
use crate::tolerance::{self, Inexact, UNDERFLOW};
use nalgebra::SMatrix;

/// Compares rotations and strains.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (found, cpu) = (split_of(backend, subject)?, split_of(&Cpu, subject)?);
    let n = subject.poses.len();
    let [mut turns, mut strains] = ["turns", "strains"].map(Finding::new);
    for (i, pose) in subject.poses.iter().enumerate() {
        let pose = Inexact::exact(pose.widened());
        let (turn, strain) = tolerance::polar(&subject.oracle, &pose, backend.arithmetic());
        let at = |split: &Split| part(&split.turns, n, i).as_flattened().to_vec();
        compare_columns(&mut turns, &at(&found), &at(&cpu), &turn);
        let at = |split: &Split| part(&split.strains, n, i).as_flattened().to_vec();
        let expected: Vec<_> = strain.value.iter().flatten().copied().collect();
        let tolerances: Vec<_> = strain.error.iter().flatten().map(|e| e + UNDERFLOW).collect();
        strains.compare(&at(&found), &at(&cpu), &expected, &tolerances);
    }
    Ok(vec![turns, strains])
}

/// Evaluates rotations and strains for every pose; empty if no joint stretches.
///
/// # Errors
/// The backend's error.
pub fn split_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Split, Failure> {
    let envelope = &subject.loaded.envelope;
    let mut out = Split::poisoned(envelope, subject.poses.len());
    if envelope.stretches() {
        backend.polar(&subject.loaded, subject.inputs(), &mut out)?;
    }
    Ok(out)
}

/// Compares columns with the CPU's bits and with the expected values.
pub(super) fn compare_columns<const C: usize>(
    finding: &mut Finding,
    found: &[[f32; 3]],
    cpu: &[[f32; 3]],
    expected: &Inexact<SMatrix<f64, 3, C>>,
) -> bool {
    let flat = |list: &[SMatrix<f64, 3, C>]| -> Vec<f64> {
        list.iter().flat_map(|m| m.iter().copied()).collect()
    };
    let tolerances: Vec<_> = flat(&expected.error).iter().map(|e| e + UNDERFLOW).collect();
    let values = flat(&expected.value);
    finding.compare(found.as_flattened(), cpu.as_flattened(), &values, &tolerances)
}
