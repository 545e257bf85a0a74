//! Stage kernel, from queries to outputs and confidences.

use crate::backend::{Backend, Failure, part};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::finding::Finding;
use crate::kernels::KernelSubject;
use crate::tolerance::{self, UNDERFLOW};

/// Compares outputs and confidences.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &KernelSubject<'_>) -> Result<Vec<Finding>, Failure> {
    let n = subject.query_len();
    let (found, certain) = outputs_of(backend, subject)?;
    let (cpu, cpu_certain) = outputs_of(&Cpu, subject)?;
    let [mut outputs, mut confidences] = ["outputs", "confidence"].map(Finding::new);
    for i in 0..n {
        let query = part(&subject.queries, n, i);
        let (right, confidence) = tolerance::kernel(&subject.oracle, query, backend.arithmetic());
        let tolerances: Vec<_> = right.error.iter().map(|error| error + UNDERFLOW).collect();
        outputs.compare(part(&found, n, i), part(&cpu, n, i), &right.value, &tolerances);
        let (found, cpu) = (&certain[i..=i], &cpu_certain[i..=i]);
        confidences.compare(found, cpu, &confidence.value, &confidence.error);
    }
    Ok(vec![outputs, confidences])
}

/// Evaluates outputs and confidences.
///
/// # Errors
/// The backend's error.
pub fn outputs_of(
    backend: &dyn Backend,
    subject: &KernelSubject<'_>,
) -> Result<(Vec<f32>, Vec<f32>), Failure> {
    let n = subject.query_len();
    let mut outputs = vec![POISON; n * subject.kernel.result_len()];
    let mut confidences = vec![POISON; n];
    backend.kernel(subject, &subject.queries, &mut outputs, &mut confidences)?;
    Ok((outputs, confidences))
}
