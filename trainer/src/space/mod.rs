//! Axes, handedness and unit of a space: requests for them, and the conversion from one space to another.

mod conversion;

pub use conversion::Conversion;
pub(crate) use conversion::{axis, axis_names, direction, rotations};

use conversion::metres;
use sinew_runtime::format::{Axis, Handedness, Space};

/// Allowed lengths of a unit, in metres, as in the file.
pub(crate) const UNITS: std::ops::RangeInclusive<f32> = 1e-9..=1e9;

/// Likely ratios between the units of two files: powers of ten and inches, 1 first.
pub(crate) const SCALES: [f64; 11] =
    [1.0, 0.01, 100.0, 0.1, 10.0, 0.001, 1000.0, 0.0254, 1.0 / 0.0254, 2.54, 1.0 / 2.54];

/// A request for a space; `None` keeps the present value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpaceRequest {
    /// Direction of a character's head.
    pub up: Option<Axis>,
    /// Direction in which a character looks.
    pub forward: Option<Axis>,
    /// Handedness of the axes.
    pub handedness: Option<Handedness>,
    /// Length of a unit, in metres.
    pub unit: Option<f32>,
}

/// A space that cannot exist, or that cannot be reached.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpaceError {
    /// Up and forward lie along one line.
    #[error(
        "up {} and forward {} lie along one line: give an up and a forward that are square to each \
         other",
        up.name(),
        forward.name()
    )]
    Parallel {
        /// Direction of a character's head.
        up: Axis,
        /// Direction in which the character looks.
        forward: Axis,
    },
    /// The unit is not a length.
    #[error("a unit of {metres} m: expected a length from 1e-9 to 1e9 m")]
    Unit {
        /// Length of the unit.
        metres: f32,
    },
    /// Neither the file nor the user states an axis.
    #[error(
        "the file does not say which axis is {what}: say it with {flag} AXIS, as {flag} {like}"
    )]
    UnknownAxis {
        /// `up` or `forward`.
        what: &'static str,
        /// Option that states the axis.
        flag: &'static str,
        /// Example of a value for the option.
        like: &'static str,
    },
    /// Neither the file nor the user states the length of the unit.
    #[error(
        "the file does not say how long its unit is: say it with --unit METRES, as --unit 0.01"
    )]
    UnknownUnit,
}

impl SpaceRequest {
    /// Requests everything that a space states.
    pub fn all_of(space: &Space) -> Self {
        let Space { up, forward, handedness, unit } = *space;
        Self { up, forward, handedness: Some(handedness), unit }
    }

    /// Whether the request asks for nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Applies the request to a space.
    ///
    /// # Errors
    /// [`SpaceError::Parallel`] and [`SpaceError::Unit`].
    pub fn of(&self, space: Space) -> Result<Space, SpaceError> {
        let (up, forward) = (self.up.or(space.up), self.forward.or(space.forward));
        if let (Some(up), Some(forward)) = (up, forward)
            && up.is_along(forward)
        {
            return Err(SpaceError::Parallel { up, forward });
        }
        if let Some(metres) = self.unit.filter(|unit| !UNITS.contains(unit)) {
            return Err(SpaceError::Unit { metres });
        }
        let handedness = self.handedness.unwrap_or(space.handedness);
        Ok(Space { up, forward, handedness, unit: self.unit.or(space.unit) })
    }
}

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

    const GLTF: Space = Space::GLTF;

    #[test]
    fn contradictory_spaces_are_refused() {
        for (up, forward) in [(Axis::Z, Axis::Z), (Axis::Z, Axis::MinusZ), (Axis::MinusY, Axis::Y)]
        {
            let request =
                SpaceRequest { up: Some(up), forward: Some(forward), ..SpaceRequest::default() };
            assert_eq!(request.of(GLTF), Err(SpaceError::Parallel { up, forward }));
        }
        // The request and the file may contradict each other.
        let request = SpaceRequest { up: Some(Axis::Z), ..SpaceRequest::default() };
        assert!(matches!(request.of(GLTF), Err(SpaceError::Parallel { .. })));
        for metres in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-10] {
            let request = SpaceRequest { unit: Some(metres), ..SpaceRequest::default() };
            assert!(matches!(request.of(GLTF), Err(SpaceError::Unit { .. })), "{metres}");
        }
    }

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
