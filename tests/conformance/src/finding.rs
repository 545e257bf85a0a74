//! The result of comparing an output of a stage.

use crate::compare::{Mismatch, differing, same_bits, within};

/// An output compared with the oracle, and with the CPU on equal inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The output's name.
    pub output: &'static str,
    /// Values compared.
    pub values: usize,
    /// Number of values that differ from the CPU's in a bit.
    pub differing: usize,
    /// The largest deviation from the oracle, in units of the tolerance.
    pub worst: f64,
    /// The worst value of the first pose that has a value beyond its tolerance.
    pub mismatch: Option<Mismatch>,
}

impl Finding {
    /// Starts a finding without values.
    pub fn new(output: &'static str) -> Self {
        Self { output, values: 0, differing: 0, worst: 0.0, mismatch: None }
    }

    /// Compares values with the CPU's bits, and with the oracle within tolerances; returns whether
    /// all are within.
    pub fn compare(
        &mut self,
        found: &[f32],
        cpu: &[f32],
        expected: &[f64],
        tolerances: &[f64],
    ) -> bool {
        self.add(found, cpu, within(found, expected, tolerances))
    }

    /// Compares values bit by bit with the expected ones; returns whether all are equal.
    pub fn equal(&mut self, found: &[f32], expected: &[f32]) -> bool {
        self.add(found, expected, same_bits(found, expected).map(|()| 0.0))
    }

    fn add(&mut self, found: &[f32], cpu: &[f32], result: Result<f64, Mismatch>) -> bool {
        self.values += found.len();
        self.differing += differing(found, cpu);
        self.worst = self.worst.max(result.unwrap_or_else(|mismatch| mismatch.ratio()));
        self.mismatch = self.mismatch.or(result.err());
        result.is_ok()
    }
}

/// Checks that every output was compared and is within its tolerances.
///
/// # Errors
/// The first [`Mismatch`]; [`Mismatch::Empty`] if an output has no values, or if there is none.
pub fn sound(findings: &[Finding]) -> Result<(), Mismatch> {
    if findings.is_empty() {
        return Err(Mismatch::Empty);
    }
    for Finding { values, mismatch, .. } in findings {
        if let Some(mismatch) = mismatch {
            return Err(*mismatch);
        }
        if *values == 0 {
            return Err(Mismatch::Empty);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_add_up_and_keep_the_first_mismatch() {
        let mut finding = Finding::new("x");
        assert_eq!(sound(&[finding.clone()]), Err(Mismatch::Empty));
        assert!(finding.compare(&[1.0, 2.0], &[1.0, 2.5], &[1.0, 2.0], &[1.0, 1.0]));
        assert!(finding.compare(&[1.5], &[1.5], &[1.0], &[1.0]));
        assert_eq!((finding.values, finding.differing, finding.worst), (3, 1, 0.5));
        assert_eq!(sound(&[finding.clone()]), Ok(()));
        assert!(!finding.compare(&[4.0], &[4.0], &[1.0], &[1.0]));
        assert!(!finding.compare(&[9.0], &[9.0], &[1.0], &[1.0]));
        let first = Mismatch::Beyond { index: 0, expected: 1.0, found: 4.0, tolerance: 1.0 };
        assert_eq!((finding.worst, sound(&[finding])), (8.0, Err(first)));
        assert_eq!(sound(&[]), Err(Mismatch::Empty));
    }

    #[test]
    fn other_bits_are_infinitely_far() {
        let mut finding = Finding::new("x");
        assert!(finding.equal(&[1.0], &[1.0]));
        assert!(!finding.equal(&[0.0], &[-0.0]));
        assert_eq!((finding.values, finding.differing, finding.worst), (2, 1, f64::INFINITY));
    }
}
