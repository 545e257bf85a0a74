//! Errors that several files of this module make.

use crate::Error;

/// Returns the error of a number that is out of its range.
pub(super) fn wrong_number(what: &str, expected: &str, found: f64) -> Error {
    Error::value(format!("{what}: expected {expected}, found {}", shown(found)))
}

/// Returns the error of an empty list of observations.
pub(super) fn no_observations() -> Error {
    Error::missing("there are no observations")
}

/// Returns the error of a signal that is shorter than a window.
pub(super) fn too_short(found: usize, least: usize) -> Error {
    Error::fit(format!("{found} samples are fewer than a window's {least}: take fewer taps"))
}

/// Checks that a number is positive and finite.
///
/// # Errors
/// If the number is not.
pub(super) fn check_positive(what: &str, found: f64) -> Result<(), Error> {
    let sound = found > 0.0 && found.is_finite();
    if sound { Ok(()) } else { Err(wrong_number(what, "a finite number above 0", found)) }
}

/// Formats a number; very large and very small numbers get an exponent.
fn shown(number: f64) -> String {
    let is_usual = number == 0.0 || (1e-6..1e15).contains(&number.abs());
    if is_usual { format!("{number}") } else { format!("{number:e}") }
}
