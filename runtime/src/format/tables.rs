//! Rows of the two tables, kinds of parts, and types of elements.

use crate::named::named;

named! {
    /// A kind of part. A number never changes meaning.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u16)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum PartKind {
        /// Predicts a palette from a pose (METHOD §1).
        Envelope = 1, "envelope";
        /// A mesh that follows a palette.
        Skin = 2, "skin";
        /// A function of a few numbers (METHOD §2).
        Kernel = 3, "kernel";
        /// Prior of the weights of a skin's shapes (METHOD §5.1).
        Prior = 4, "prior";
        /// A drawn object between its key views (METHOD §6).
        Views = 5, "views";
        /// Increases the sampling rate of a signal (METHOD §4).
        Filter = 6, "filter";
        /// Record of an envelope's training.
        Record = 7, "record";
    }
    /// Every kind.
    pub ALL;
    /// Returns its name, as on the command line.
    pub name;
}

impl PartKind {
    /// Returns its number in the file.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// Returns the kind with this number.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn from_number(number: u16) -> Option<Self> {
        let mut at = 0;
        while at < Self::ALL.len() {
            if Self::ALL[at].number() == number {
                return Some(Self::ALL[at]);
            }
            at += 1;
        }
        None
    }
}

/// Kinds that this build evaluates. Other kinds are treated as unknown.
pub(crate) const EVALUATED: [PartKind;
    2 + cfg!(feature = "kernel") as usize
        + cfg!(feature = "prior") as usize
        + cfg!(feature = "views") as usize
        + cfg!(feature = "filter") as usize
        + cfg!(feature = "record") as usize] = [
    PartKind::Envelope,
    PartKind::Skin,
    #[cfg(feature = "kernel")]
    PartKind::Kernel,
    #[cfg(feature = "prior")]
    PartKind::Prior,
    #[cfg(feature = "views")]
    PartKind::Views,
    #[cfg(feature = "filter")]
    PartKind::Filter,
    #[cfg(feature = "record")]
    PartKind::Record,
];

// No feature changes the list.
const _: () = assert!(PartKind::ALL.len() == 7);

/// A row of the part table. The part's sections hold its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartRow {
    /// Number of a [`PartKind`].
    pub kind: u16,
    /// Bit 0: a reader that does not know the kind must refuse the file.
    pub flags: u16,
}

impl PartRow {
    /// Bytes of a row.
    pub const BYTES: usize = 4;

    /// Makes the row of a part. The row is required if evaluation needs the part.
    pub const fn new(kind: PartKind) -> Self {
        let flags = if matches!(kind, PartKind::Record) { 0 } else { REQUIRED };
        Self { kind: kind.number(), flags }
    }

    /// Whether a reader that does not know this part must refuse the file.
    pub const fn required(&self) -> bool {
        self.flags & REQUIRED != 0
    }

    /// Writes the row, little-endian.
    pub const fn to_bytes(&self) -> [u8; Self::BYTES] {
        let ([k0, k1], [f0, f1]) = (self.kind.to_le_bytes(), self.flags.to_le_bytes());
        [k0, k1, f0, f1]
    }

    /// Reads a row.
    pub const fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let [k0, k1, f0, f1] = *bytes;
        Self { kind: u16::from_le_bytes([k0, k1]), flags: u16::from_le_bytes([f0, f1]) }
    }
}

named! {
    /// Type of a section's elements. A number never changes meaning.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    pub enum Element {
        /// Records or text, in a layout that depends on the section's kind.
        Mixed = 0, "mixed";
        /// IEEE 754 single precision.
        F32 = 1, "f32";
        /// Unsigned, 16 bits.
        U16 = 2, "u16";
        /// Unsigned, 32 bits.
        U32 = 3, "u32";
        /// IEEE 754 half precision.
        F16 = 4, "f16";
        /// Signed, 8 bits, two's complement.
        I8 = 5, "i8";
    }
    /// Every type.
    pub ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

impl Element {
    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the bytes of one number; 1 for mixed elements.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 | Self::U32 => 4,
            Self::U16 | Self::F16 => 2,
            Self::Mixed | Self::I8 => 1,
        }
    }
}

/// A row of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SectionRow {
    /// Number of a [`super::SectionKind`].
    pub kind: u16,
    /// Row of the section's part in the part table.
    pub part: u16,
    /// Number of an [`Element`].
    pub element: u8,
    /// Bit 0: a reader that does not know the kind must refuse the file.
    pub flags: u8,
    /// Reserved; zero.
    pub reserved: u16,
    /// Start of the section, in bytes from the blob's start.
    pub offset: u32,
    /// Its length in bytes.
    pub bytes: u32,
}

impl SectionRow {
    /// Bytes of a row.
    pub const BYTES: usize = 16;

    /// Whether a reader that does not know this section must refuse the file.
    pub const fn required(&self) -> bool {
        self.flags as u16 & REQUIRED != 0
    }

    /// Writes the row, little-endian.
    pub const fn to_bytes(&self) -> [u8; Self::BYTES] {
        let ([k0, k1], [p0, p1]) = (self.kind.to_le_bytes(), self.part.to_le_bytes());
        let ([r0, r1], [e, f]) = (self.reserved.to_le_bytes(), [self.element, self.flags]);
        let [o0, o1, o2, o3] = self.offset.to_le_bytes();
        let [b0, b1, b2, b3] = self.bytes.to_le_bytes();
        [k0, k1, p0, p1, e, f, r0, r1, o0, o1, o2, o3, b0, b1, b2, b3]
    }

    /// Reads a row.
    pub const fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let [k0, k1, p0, p1, element, flags, r0, r1, o0, o1, o2, o3, b0, b1, b2, b3] = *bytes;
        Self {
            kind: u16::from_le_bytes([k0, k1]),
            part: u16::from_le_bytes([p0, p1]),
            element,
            flags,
            reserved: u16::from_le_bytes([r0, r1]),
            offset: u32::from_le_bytes([o0, o1, o2, o3]),
            bytes: u32::from_le_bytes([b0, b1, b2, b3]),
        }
    }
}

/// Flag of a row that a reader must understand.
pub(crate) const REQUIRED: u16 = 1;
