//! Axes, handedness and unit of a space: requests for them, and the conversion from one space to another.

mod conversion;

pub use conversion::{Conversion, SpaceRequest};
pub(crate) use conversion::{UNITS, axis, axis_names, direction, rotations};

use conversion::metres;
use sinew_runtime::format::Space;

/// Likely ratios between the units of two files: powers of ten and inches, 1 first.
pub(crate) const SCALES: [f64; 11] =
    [1.0, 0.01, 100.0, 0.1, 10.0, 0.001, 1000.0, 0.0254, 1.0 / 0.0254, 2.54, 1.0 / 2.54];

/// Returns the length of a unit in millimetres; `None` if the unit is not known.
pub fn millimetres(space: &Space) -> Option<f64> {
    space.unit.map(|unit| 1000.0 * metres(unit))
}

/// Formats a length in millimetres, without the unit: to the micrometre, or with an exponent from a kilometre on.
pub fn written(millimetres: f64) -> String {
    if millimetres < 1e6 { format!("{millimetres:.3}") } else { format!("{millimetres:.2e}") }
}

/// Formats ` (1.234 mm)` to stand behind a percentage of the diagonal; empty if the diagonal is not known.
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
