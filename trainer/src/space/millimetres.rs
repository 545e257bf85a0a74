//! Lengths in millimetres, where the unit of a space is known.

use super::conversion::metres;
use sinew_runtime::format::Space;

/// Returns how many millimetres a unit of length has; `None` where the unit is not known.
pub fn millimetres(space: &Space) -> Option<f64> {
    space.unit.map(|unit| 1000.0 * metres(unit))
}

/// Writes a length in millimetres without its unit: to the micrometre, or with an exponent from a kilometre on.
pub fn written(millimetres: f64) -> String {
    if millimetres < 1e6 { format!("{millimetres:.3}") } else { format!("{millimetres:.2e}") }
}

/// Writes ` (1.234 mm)` to stand behind a share of the diagonal; nothing where the diagonal is not known.
pub fn beside(percent: f64, diagonal_mm: Option<f64>) -> String {
    let length = diagonal_mm.map(|diagonal| written(percent / 100.0 * diagonal));
    length.map_or(String::new(), |length| format!(" ({length} mm)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_the_decimal_number_that_was_meant() {
        let of = |unit| millimetres(&Space { unit, ..Space::default() });
        assert_eq!([of(Some(1.0)), of(Some(0.01)), of(None)], [Some(1000.0), Some(10.0), None]);
    }

    #[test]
    fn a_length_takes_few_digits() {
        assert_eq!(
            [0.0, 0.01234, 999_999.0, 1e30].map(written),
            ["0.000", "0.012", "999999.000", "1.00e30"]
        );
        assert_eq!(beside(0.5, Some(2000.0)), " (10.000 mm)");
        assert_eq!(beside(0.5, None), "");
    }
}
