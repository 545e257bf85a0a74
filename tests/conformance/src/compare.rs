//! Comparators. Each fails on a NaN, on empty input, and on different lengths.

use thiserror::Error;

/// The failure of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Mismatch {
    /// There is nothing to compare.
    #[error("there is nothing to compare")]
    Empty,
    /// The lists have different lengths.
    #[error("{found} values, expected {expected}")]
    Length {
        /// Values expected.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// A value differs from the expected value by more than its tolerance, or one of the three
    /// numbers is NaN.
    #[error("value {index} is {found:?}, expected {expected:?} within {tolerance:.3e}")]
    Beyond {
        /// Index of the value.
        index: usize,
        /// The value expected.
        expected: f64,
        /// The value found.
        found: f32,
        /// The tolerance.
        tolerance: f64,
    },
    /// A value is NaN or differs from the expected value in a bit.
    #[error("value {index} is {found:?}, expected the bits of {expected:?}")]
    Bits {
        /// Index of the value.
        index: usize,
        /// The value expected.
        expected: f32,
        /// The value found.
        found: f32,
    },
}

impl Mismatch {
    /// Returns the error in units of the tolerance; infinity if it cannot be measured.
    pub fn ratio(&self) -> f64 {
        match *self {
            Self::Beyond { expected, found, tolerance, .. } => {
                let ratio = (f64::from(found) - expected).abs() / tolerance;
                if ratio > 0.0 { ratio } else { f64::INFINITY }
            }
            _ => f64::INFINITY,
        }
    }
}

/// A NaN that no arithmetic produces. A float that holds it has not been written.
pub const POISON: f32 = f32::from_bits(0x7fc5_1e37);

/// Returns an output that a backend must write completely: a comparison fails on any value left as
/// it is.
pub fn poisoned<const N: usize>(len: usize) -> Vec<[f32; N]> {
    vec![[POISON; N]; len]
}

/// Counts the values that are NaN or differ in a bit, plus the difference in length.
pub fn differing(found: &[f32], expected: &[f32]) -> usize {
    let pairs = found.iter().zip(expected);
    let other =
        |(found, expected): &(&f32, &f32)| found.is_nan() || found.to_bits() != expected.to_bits();
    pairs.filter(other).count() + found.len().abs_diff(expected.len())
}

/// Compares each value with the expected value, within its own tolerance; returns the largest ratio
/// of an error to its tolerance.
///
/// # Errors
/// [`Mismatch`] of the value that exceeds its tolerance by the largest factor.
pub fn within(found: &[f32], expected: &[f64], tolerances: &[f64]) -> Result<f64, Mismatch> {
    check_lens(expected.len(), found.len())?;
    check_lens(expected.len(), tolerances.len())?;
    let mut worst = 0.0_f64;
    let mut beyond: Option<Mismatch> = None;
    let pairs = found.iter().zip(expected).zip(tolerances);
    for (index, ((&found, &expected), &tolerance)) in pairs.enumerate() {
        let error = (f64::from(found) - expected).abs();
        // Written so that any NaN fails.
        let holds = error <= tolerance && expected.is_finite();
        if !holds {
            let this = Mismatch::Beyond { index, expected, found, tolerance };
            if beyond.is_none_or(|other| other.ratio() < this.ratio()) {
                beyond = Some(this);
            }
        } else if error > 0.0 {
            worst = worst.max(error / tolerance);
        }
    }
    beyond.map_or(Ok(worst), Err)
}

/// Compares values bit by bit.
///
/// # Errors
/// The first [`Mismatch`].
pub fn same_bits(found: &[f32], expected: &[f32]) -> Result<(), Mismatch> {
    check_lens(expected.len(), found.len())?;
    for (index, (&found, &expected)) in found.iter().zip(expected).enumerate() {
        if found.is_nan() || found.to_bits() != expected.to_bits() {
            return Err(Mismatch::Bits { index, expected, found });
        }
    }
    Ok(())
}

fn check_lens(expected: usize, found: usize) -> Result<(), Mismatch> {
    if expected != found {
        return Err(Mismatch::Length { expected, found });
    }
    if expected == 0 { Err(Mismatch::Empty) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f64 = f64::NAN;

    #[test]
    fn the_largest_ratio_is_returned() {
        assert_eq!(within(&[1.0, 2.5], &[1.0, 2.0], &[0.0, 1.0]), Ok(0.5));
    }

    #[test]
    fn a_value_beyond_its_tolerance_fails() {
        let beyond = Mismatch::Beyond { index: 1, expected: 2.0, found: 2.5, tolerance: 0.49 };
        assert_eq!(within(&[1.0, 2.5], &[1.0, 2.0], &[9.0, 0.49]), Err(beyond));
        assert!(within(&[1.0], &[1.0 + 1e-15], &[0.0]).is_err());
    }

    #[test]
    fn the_value_farthest_off_is_named() {
        let farthest = within(&[1.0, 2.0, 3.0], &[0.0; 3], &[0.9, 0.1, 9.0]).unwrap_err();
        let expected = Mismatch::Beyond { index: 1, expected: 0.0, found: 2.0, tolerance: 0.1 };
        assert_eq!((farthest, farthest.ratio()), (expected, 20.0));
        let nan = within(&[1.0, f32::NAN], &[0.0; 2], &[0.1; 2]).unwrap_err();
        assert!(matches!(nan, Mismatch::Beyond { index: 1, .. }) && nan.ratio() == f64::INFINITY);
        assert_eq!(Mismatch::Empty.ratio(), f64::INFINITY);
    }

    #[test]
    fn what_differs_is_counted() {
        assert_eq!(differing(&[1.0, -0.0, 2.0], &[1.0, 0.0, 2.0_f32.next_up()]), 2);
        assert_eq!(differing(&[f32::NAN, POISON], &[f32::NAN, POISON]), 2);
        assert_eq!(differing(&[1.0], &[1.0, 1.0]) + differing(&[1.0; 3], &[1.0]), 3);
        assert_eq!(differing(&[1.0, -0.0], &[1.0, -0.0]), 0);
    }

    #[test]
    fn a_nan_anywhere_fails() {
        assert!(within(&[f32::NAN], &[1.0], &[f64::INFINITY]).is_err());
        assert!(within(&[1.0], &[NAN], &[f64::INFINITY]).is_err());
        assert!(within(&[1.0], &[1.0], &[NAN]).is_err());
        assert!(within(&[1.0], &[1.0], &[-1.0]).is_err());
        assert!(within(&[f32::INFINITY], &[f64::INFINITY], &[1.0]).is_err());
        assert!(same_bits(&[f32::NAN], &[f32::NAN]).is_err());
        assert!(same_bits(poisoned::<3>(2).as_flattened(), &[0.0; 6]).is_err());
    }

    #[test]
    fn nothing_to_compare_fails() {
        assert_eq!(within(&[], &[], &[]), Err(Mismatch::Empty));
        assert_eq!(same_bits(&[], &[]), Err(Mismatch::Empty));
    }

    #[test]
    fn lengths_that_differ_fail() {
        let length = |expected, found| Mismatch::Length { expected, found };
        assert_eq!(within(&[1.0], &[1.0, 1.0], &[1.0, 1.0]), Err(length(2, 1)));
        assert_eq!(within(&[1.0, 1.0], &[1.0, 1.0], &[1.0]), Err(length(2, 1)));
        assert_eq!(same_bits(&[1.0], &[]), Err(length(0, 1)));
    }

    #[test]
    fn one_bit_fails() {
        assert_eq!(same_bits(&[1.0, -0.0], &[1.0, -0.0]), Ok(()));
        assert!(same_bits(&[1.0], &[f32::from_bits(1.0_f32.to_bits() + 1)]).is_err());
        assert!(same_bits(&[0.0], &[-0.0]).is_err());
    }
}
