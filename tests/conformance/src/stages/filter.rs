//! Stage filter, from samples to finer samples.

use crate::backend::{Backend, Failure};
use crate::compare::POISON;
use crate::cpu::Cpu;
use crate::filters::FilterSubject;
use crate::finding::Finding;
use crate::tolerance::{self, UNDERFLOW};

/// Compares every number.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &FilterSubject<'_>) -> Result<Vec<Finding>, Failure> {
    let (found, cpu) = (finer_by(backend, subject)?, finer_by(&Cpu, subject)?);
    let mut finding = Finding::new("samples");
    for (place, (found, cpu)) in found.iter().zip(&cpu).enumerate() {
        let (value, error) = tolerance::filter(subject, place);
        finding.compare(&[*found], &[*cpu], &[value], &[error + UNDERFLOW]);
    }
    Ok(vec![finding])
}

/// Makes all signals of a subject finer.
///
/// # Errors
/// The backend's error.
pub fn finer_by(backend: &dyn Backend, subject: &FilterSubject<'_>) -> Result<Vec<f32>, Failure> {
    let mut out = vec![POISON; subject.samples.len() * subject.filter.factor()];
    backend.filter(subject, &mut out)?;
    Ok(out)
}
