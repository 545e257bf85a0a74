//! Rows of section `outputs`: what a kernel gives.

use crate::linear::{floats, squared_length};
use crate::skin::LENGTH_TOLERANCE;

/// What an output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum OutputKind {
    /// A number.
    Scalar = 1,
    /// Three numbers.
    Vector3 = 2,
    /// A rotation, a quaternion x, y, z, w of length 1; its 3 values are its vector from the neutral one.
    Rotation = 3,
}

impl OutputKind {
    /// Every kind, by number from 1.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Vector3, Self::Rotation];

    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the kind of this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Vector3 => "vector3",
            Self::Rotation => "rotation",
        }
    }

    /// Returns how many values it is made of.
    pub const fn value_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 | Self::Rotation => 3,
        }
    }

    /// Returns how many numbers it gives.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 => 3,
            Self::Rotation => 4,
        }
    }
}

/// A row of section `outputs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputRow {
    /// What it is.
    pub kind: OutputKind,
    /// Whether it is one of those that are normalised together; of scalars alone.
    pub is_marked: bool,
    /// The least and the most of a scalar, else zeros; [`f32::MIN`] and [`f32::MAX`] keep nothing back.
    pub range: (f32, f32),
    /// What it tends to where a query fades: a scalar, a vector, or the rotation that its vectors start
    /// from, of length 1; zeros behind.
    pub neutral: [f32; 4],
}

impl OutputRow {
    /// Bytes of a row.
    pub const BYTES: usize = 28;

    /// Writes the row, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let Self { kind, is_marked, range: (low, high), neutral: [a, b, c, d] } = *self;
        let [low, high, a, b, c, d] = [low, high, a, b, c, d].map(f32::to_le_bytes);
        let head = [kind.number(), u8::from(is_marked), 0, 0];
        let mut out = [0; Self::BYTES];
        out.copy_from_slice([head, low, high, a, b, c, d].as_flattened());
        out
    }

    /// Reads a row.
    ///
    /// # Errors
    /// The number that stands for nothing: of a kind, of a mark, or reserved and not 0.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Result<Self, u8> {
        let ([kind, marked, r0, r1], words) = match bytes.as_chunks().0 {
            [head, words @ ..] => (*head, words),
            [] => return Err(0),
        };
        let [low, high, a, b, c, d] = words.first_chunk().map(floats).unwrap_or_default();
        let kind = OutputKind::from_number(kind).ok_or(kind)?;
        match (marked, r0 | r1) {
            (0 | 1, 0) => {}
            (0 | 1, reserved) => return Err(reserved),
            (marked, _) => return Err(marked),
        }
        Ok(Self { kind, is_marked: marked == 1, range: (low, high), neutral: [a, b, c, d] })
    }

    /// Whether its numbers are what its kind has: a range, a neutral, zeros for the rest.
    pub(super) fn is_sound(&self) -> bool {
        let Self { kind, is_marked, range: (low, high), neutral } = *self;
        let [_, y, z, w] = neutral;
        match kind {
            OutputKind::Scalar => low <= high && [y, z, w] == [0.0; 3],
            _ if is_marked || (low, high) != (0.0, 0.0) => false,
            OutputKind::Vector3 => w == 0.0,
            OutputKind::Rotation => (squared_length(neutral) - 1.0).abs() <= LENGTH_TOLERANCE,
        }
    }

    /// Returns the values that stand for the neutral: of a rotation the vector 0.
    pub(super) const fn neutral_values(&self) -> [f32; 3] {
        let [x, y, z, _] = self.neutral;
        match self.kind {
            OutputKind::Rotation => [0.0; 3],
            _ => [x, y, z],
        }
    }
}
