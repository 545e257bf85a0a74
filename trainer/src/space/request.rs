//! What is asked of a space, and which spaces cannot be.

use sinew_runtime::format::{Axis, Handedness, Space};

/// Metres that a unit of length may have, as in the file.
pub(crate) const UNITS: std::ops::RangeInclusive<f32> = 1e-9..=1e9;

/// The units of one file in those of another: powers of ten and inches, 1 first.
pub(crate) const SCALES: [f64; 11] =
    [1.0, 0.01, 100.0, 0.1, 10.0, 0.001, 1000.0, 0.0254, 1.0 / 0.0254, 2.54, 1.0 / 2.54];

/// What is said of a space; what is not said stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpaceRequest {
    /// Where a character's head is.
    pub up: Option<Axis>,
    /// Where a character looks.
    pub forward: Option<Axis>,
    /// The axes' handedness.
    pub handedness: Option<Handedness>,
    /// Metres of a unit of length.
    pub unit: Option<f32>,
}

/// A space that nothing can be in, or that cannot be reached.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpaceError {
    /// Two axes lie along one line.
    #[error(
        "up {} and forward {} lie along one line: give an up and a forward that are square to each \
         other",
        up.name(),
        forward.name()
    )]
    Parallel {
        /// Where a character's head is.
        up: Axis,
        /// Where it looks.
        forward: Axis,
    },
    /// A unit is no length.
    #[error("a unit of {metres} m: expected a length from 1e-9 to 1e9 m")]
    Unit {
        /// Its length.
        metres: f32,
    },
    /// Where an axis points is neither in the file nor said.
    #[error(
        "the file does not say which axis is {what}: say it with {flag} AXIS, as {flag} {like}"
    )]
    UnknownAxis {
        /// Up, or forward.
        what: &'static str,
        /// The option that says it.
        flag: &'static str,
        /// A value of it.
        like: &'static str,
    },
    /// The length of a unit is neither in the file nor said.
    #[error(
        "the file does not say how long its unit is: say it with --unit METRES, as --unit 0.01"
    )]
    UnknownUnit,
}

impl SpaceRequest {
    /// Says what a space says.
    pub fn all_of(space: &Space) -> Self {
        let Space { up, forward, handedness, unit } = *space;
        Self { up, forward, handedness: Some(handedness), unit }
    }

    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Says it of a space.
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

#[cfg(test)]
mod tests {
    use super::*;

    const GLTF: Space = Space::GLTF;

    #[test]
    fn spaces_that_cannot_be_are_refused() {
        for (up, forward) in [(Axis::Z, Axis::Z), (Axis::Z, Axis::MinusZ), (Axis::MinusY, Axis::Y)]
        {
            let request =
                SpaceRequest { up: Some(up), forward: Some(forward), ..SpaceRequest::default() };
            assert_eq!(request.of(GLTF), Err(SpaceError::Parallel { up, forward }));
        }
        // What is said and what the file says may not agree.
        let request = SpaceRequest { up: Some(Axis::Z), ..SpaceRequest::default() };
        assert!(matches!(request.of(GLTF), Err(SpaceError::Parallel { .. })));
        for metres in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-10] {
            let request = SpaceRequest { unit: Some(metres), ..SpaceRequest::default() };
            assert!(matches!(request.of(GLTF), Err(SpaceError::Unit { .. })), "{metres}");
        }
    }
}
