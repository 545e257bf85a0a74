//! The coordinate space of a file: its axes and its unit of length.

use super::message::SPACE_OFFSET;
use crate::named::named;

named! {
    /// A direction along an axis.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    pub enum Axis {
        /// Along x.
        X = 1, "x";
        /// Against x.
        MinusX = 2, "-x";
        /// Along y.
        Y = 3, "y";
        /// Against y.
        MinusY = 4, "-y";
        /// Along z.
        Z = 5, "z";
        /// Against z.
        MinusZ = 6, "-z";
    }
    /// Every direction.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) ALL;
    /// Returns its name, as on the command line.
    pub name;
}

impl Axis {
    /// Returns its number in the file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the direction of this number.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Whether both directions lie along one axis.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn is_along(self, other: Self) -> bool {
        (self as u8 - 1) / 2 == (other as u8 - 1) / 2
    }
}

/// Direction of the third axis relative to the first two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Handedness {
    /// x cross y is z, as in glTF.
    #[default]
    Right = 1,
    /// x cross y is -z, as in Unity and Unreal.
    Left = 2,
}

/// The coordinate space of a file: of its rest meshes, its poses, and its results.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Space {
    /// Direction from a character's feet to its head; `None` if the examples did not say.
    pub up: Option<Axis>,
    /// Direction in which a character looks.
    pub forward: Option<Axis>,
    /// The axes' handedness.
    pub handedness: Handedness,
    /// Metres per unit of length.
    pub unit: Option<f32>,
}

impl Space {
    /// The space of glTF.
    pub const GLTF: Self = Self {
        up: Some(Axis::Y),
        forward: Some(Axis::Z),
        handedness: Handedness::Right,
        unit: Some(1.0),
    };
    /// The space of Unity.
    pub const UNITY: Self = Self { handedness: Handedness::Left, ..Self::GLTF };
    /// The space of Unreal.
    pub const UNREAL: Self = Self {
        up: Some(Axis::Z),
        forward: Some(Axis::X),
        handedness: Handedness::Left,
        unit: Some(0.01),
    };

    /// Encodes the space as in the file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn to_bytes(&self) -> [u8; 8] {
        let axis = |axis: Option<Axis>| axis.map_or(0, Axis::number);
        let [a, b, c, d] = self.unit.unwrap_or_default().to_le_bytes();
        [axis(self.up), axis(self.forward), self.handedness as u8, 0, a, b, c, d]
    }

    /// Returns the bytes of the space in a file; zeros if the file is too short.
    pub(crate) fn bytes(file: &[u8]) -> [u8; 8] {
        file.get(SPACE_OFFSET..).and_then(<[u8]>::first_chunk).copied().unwrap_or_default()
    }

    /// Decodes the space of a file; invalid values read as the defaults.
    pub(crate) fn of(file: &[u8]) -> Self {
        let [up, forward, handedness, _, unit @ ..] = Self::bytes(file);
        let unit = f32::from_le_bytes(unit);
        Self {
            up: Axis::from_number(up),
            forward: Axis::from_number(forward),
            handedness: if handedness == 2 { Handedness::Left } else { Handedness::Right },
            unit: if unit.to_bits() == 0 { None } else { Some(unit) },
        }
    }

    /// Finds the first byte with an invalid value.
    pub(crate) fn invalid_byte(bytes: [u8; 8]) -> Option<usize> {
        let [up, forward, handedness, reserved, unit @ ..] = bytes;
        let unit = f32::from_le_bytes(unit);
        // An axis has two numbers, the even one for its negative direction; 0 means none.
        let along = up > 0 && forward > 0 && up.div_ceil(2) == forward.div_ceil(2);
        if up > 6 {
            Some(0)
        } else if forward > 6 || along {
            Some(1)
        } else if handedness.wrapping_sub(1) > 1 {
            Some(2)
        } else if reserved != 0 {
            Some(3)
        } else if unit.to_bits() != 0 && !(1e-9..=1e9).contains(&unit) {
            Some(4)
        } else {
            None
        }
    }
}
