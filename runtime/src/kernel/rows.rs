//! Rows of the sections `inputs` and `outputs`: the numbers of a query, and those of its result.

use crate::linear::{dot, floats, squared_length};
use crate::named::named;
use crate::skin::LENGTH_TOLERANCE;

named! {
    /// Kind of an input, which decides the features (METHOD §2.3).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum InputKind {
        /// A number.
        Scalar = 1, "scalar";
        /// A vector of three numbers.
        Vector3 = 2, "vector3";
        /// A rotation, with the 9 entries of its matrix by rows as features.
        Rotation = 3, "rotation";
        /// A rotation, with the first two rows of its matrix as features.
        TwoRows = 4, "two rows";
        /// Direction of an axis after a rotation: 3 features, independent of the twist.
        Swing = 5, "swing";
        /// Twist of a rotation about an axis: 2 features, without a seam.
        Twist = 6, "twist";
        /// Twist angle in radians, with a seam at half a turn. For rigs from other tools.
        TwistAngle = 7, "twist angle";
    }
    /// Every kind, by number from 1.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

impl InputKind {
    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the kind with this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Returns its numbers in a query: 1, 3, or the 4 of a quaternion x, y, z, w.
    pub const fn number_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 => 3,
            _ => 4,
        }
    }

    /// Returns its number of features.
    pub const fn feature_len(self) -> usize {
        match self {
            Self::Scalar | Self::TwistAngle => 1,
            Self::Twist => 2,
            Self::Vector3 | Self::Swing => 3,
            Self::TwoRows => 6,
            Self::Rotation => 9,
        }
    }

    /// Whether the input is a rotation.
    pub const fn is_rotation(self) -> bool {
        !matches!(self, Self::Scalar | Self::Vector3)
    }

    /// Whether the input has an axis.
    pub const fn has_axis(self) -> bool {
        matches!(self, Self::Swing | Self::Twist | Self::TwistAngle)
    }
}

named! {
    /// Order of the three angles in an author's rotation; the first angle is applied first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    pub enum EulerOrder {
        /// About x, then y, then z.
        Xyz = 1, "XYZ";
        /// About x, then z, then y.
        Xzy = 2, "XZY";
        /// About y, then x, then z.
        Yxz = 3, "YXZ";
        /// About y, then z, then x.
        Yzx = 4, "YZX";
        /// About z, then x, then y.
        Zxy = 5, "ZXY";
        /// About z, then y, then x.
        Zyx = 6, "ZYX";
    }
    /// Every order, by number from 1.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

/// A row of section `inputs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputRow {
    /// Kind of the input.
    pub kind: InputKind,
    /// Order of the angles, if the author gave the rotation by angles. An evaluation takes a
    /// quaternion in any case.
    pub euler: Option<EulerOrder>,
    /// Axis of length 1; zeros for a kind without an axis.
    pub axis: [f32; 3],
}

impl InputRow {
    /// Bytes of a row.
    pub const BYTES: usize = 16;

    /// Writes the row, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let euler = self.euler.map_or(0, |order| order as u8);
        let [x, y, z] = self.axis.map(f32::to_le_bytes);
        let mut out = [0; Self::BYTES];
        out.copy_from_slice([[self.kind.number(), euler, 0, 0], x, y, z].as_flattened());
        out
    }

    /// Decodes the row.
    ///
    /// # Errors
    /// The first unknown number: a kind, an order, or a reserved number other than 0.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Result<Self, u8> {
        let [kind, euler, r0, r1, x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3] = *bytes;
        let order = match euler {
            0 => None,
            _ => Some(*EulerOrder::ALL.get(usize::from(euler) - 1).ok_or(euler)?),
        };
        if r0 | r1 != 0 {
            return Err(r0 | r1);
        }
        let axis = [[x0, x1, x2, x3], [y0, y1, y2, y3], [z0, z1, z2, z3]].map(f32::from_le_bytes);
        Ok(Self { kind: InputKind::from_number(kind).ok_or(kind)?, euler: order, axis })
    }

    /// Whether the axis has length 1, or is 0 for a kind without an axis.
    pub(super) fn is_sound(&self) -> bool {
        if !self.kind.has_axis() {
            return self.axis == [0.0; 3];
        }
        (dot(self.axis, self.axis) - 1.0).abs() <= LENGTH_TOLERANCE
    }
}

named! {
    /// Kind of an output.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum OutputKind {
        /// A number.
        Scalar = 1, "scalar";
        /// A vector of three numbers.
        Vector3 = 2, "vector3";
        /// A rotation, as a quaternion x, y, z, w of length 1. Its 3 values are its vector relative to
        /// the neutral rotation.
        Rotation = 3, "rotation";
    }
    /// Every kind, by number from 1.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

impl OutputKind {
    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the kind with this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Returns its number of values.
    pub const fn value_len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector3 | Self::Rotation => 3,
        }
    }

    /// Returns its numbers in a result.
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
    /// Kind of the output.
    pub kind: OutputKind,
    /// Whether the output belongs to the normalised ones; only for scalars.
    pub is_marked: bool,
    /// Least and greatest value of a scalar, else zeros. [`f32::MIN`] and [`f32::MAX`] mean no
    /// limit.
    pub range: (f32, f32),
    /// Neutral value, which a fading query approaches: a scalar, a vector, or the base rotation of
    /// the vectors, of length 1. Unused places are 0.
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

    /// Decodes the row.
    ///
    /// # Errors
    /// The first unknown number: a kind, a mark, or a reserved number other than 0.
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

    /// Whether the numbers fit the kind: the range, the neutral value, and zeros elsewhere.
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

    /// Returns the neutral values; for a rotation the vector 0.
    pub(super) const fn neutral_values(&self) -> [f32; 3] {
        let [x, y, z, _] = self.neutral;
        match self.kind {
            OutputKind::Rotation => [0.0; 3],
            _ => [x, y, z],
        }
    }
}
