//! What can go wrong: bad bytes ([`FormatError`]) and bad calls ([`EvalError`]).

use crate::format::{Predictor, SectionKind};
use crate::limits::Quantity;
use core::fmt;

/// Why a file was refused; FORMAT.md lists the checks in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormatError {
    /// More of something than the caller's [`crate::Limits`] or the format itself allow.
    Limit {
        /// What there is too much of.
        quantity: Quantity,
        /// The most allowed.
        most: u32,
        /// What the file holds; `u32::MAX` also stands for more.
        found: u32,
    },
    /// The file ends early, or a length in it is no length.
    Malformed,
    /// The first four bytes are not those of a model.
    Magic {
        /// The bytes in their place.
        found: [u8; 4],
    },
    /// Written in a version that this reader does not know.
    Version {
        /// The version of this reader.
        expected: u8,
        /// The version of the file.
        found: u8,
    },
    /// The file was changed after it was written.
    Checksum {
        /// The CRC-32 that the file states.
        expected: u32,
        /// The CRC-32 of its bytes.
        found: u32,
    },
    /// Bytes follow the end of the message.
    TrailingBytes {
        /// How many.
        found: usize,
    },
    /// The file needs features that this reader does not have.
    Features {
        /// Their bits.
        unknown: u32,
    },
    /// The power of two of the alignment is outside 4 to 12, or the blob does not start on it.
    Alignment {
        /// The power of two that the file states.
        log2: u8,
    },
    /// Padding that is not zero.
    Padding,
    /// The part table is not a whole number of rows, or has too many or none.
    PartTable {
        /// Its length in bytes.
        bytes: usize,
    },
    /// The section table is not a whole number of rows, or has too many.
    SectionTable {
        /// Its length in bytes.
        bytes: usize,
    },
    /// A row states flags that this version does not have.
    Flags {
        /// The flags found.
        found: u16,
    },
    /// A part that this reader must know and does not.
    UnknownPart {
        /// Its kind.
        kind: u8,
    },
    /// A section that this reader must know and does not.
    UnknownSection {
        /// Its kind.
        kind: u16,
    },
    /// A section names a part that is not there.
    SectionPart {
        /// Row of the section table.
        row: usize,
        /// The part it names.
        found: u8,
    },
    /// A section does not start on the file's alignment.
    SectionAlignment {
        /// Row of the section table.
        row: usize,
    },
    /// A section starts before the one listed before it ends.
    SectionOverlap {
        /// Row of the section table.
        row: usize,
    },
    /// A section reaches beyond the blob.
    SectionBounds {
        /// Row of the section table.
        row: usize,
    },
    /// A part has two sections of one kind.
    DuplicateSection {
        /// Row of the second.
        row: usize,
    },
    /// A predictor that this reader does not know.
    Predictor {
        /// Its tag.
        found: u8,
    },
    /// A count that must be at least one is zero.
    Empty {
        /// What there is none of.
        quantity: Quantity,
    },
    /// A part lacks a section.
    MissingSection {
        /// The section.
        section: SectionKind,
    },
    /// A section that the part's predictor does not have.
    UnexpectedSection {
        /// The section.
        section: SectionKind,
    },
    /// A section's length does not follow from the part's counts, or from its groups.
    SectionLength {
        /// The section.
        section: SectionKind,
        /// Bytes it should have; `u32::MAX` also stands for more.
        expected: u32,
        /// Bytes it has.
        found: usize,
    },
    /// A name that is not UTF-8, or whose place in the table is wrong.
    Name {
        /// 0 is the part, 1 + j is joint j.
        index: usize,
    },
    /// A parent or the evaluation order is not that of one tree.
    Hierarchy {
        /// The joint.
        joint: usize,
    },
    /// A float that is not finite, or larger than [`crate::format::MAGNITUDE_MAX`], or in a
    /// correction than [`crate::format::CORRECTION_MAX`]; a negative weight or pose range.
    Float {
        /// Its section; `None` for the certificate.
        section: Option<SectionKind>,
        /// Its index, in floats or words from the section's start (from the first matrix in a key).
        index: usize,
    },
    /// An index beyond what it points into.
    Index {
        /// Its section.
        section: SectionKind,
        /// Its place, in elements from the section's start.
        index: usize,
        /// One more than the greatest allowed.
        below: usize,
        /// The index found.
        found: usize,
    },
    /// The weights of a vertex do not sum to one.
    Weights {
        /// The vertex.
        vertex: usize,
    },
    /// An inverse bind matrix that is no rigid motion, by more than
    /// [`crate::format::BIND_TOLERANCE`].
    InverseBind {
        /// The joint.
        joint: usize,
    },
    /// A twist matrix is too large to keep its angle accurate.
    Twist {
        /// The key.
        key: usize,
    },
    /// A kernel that this reader does not know.
    Kernel {
        /// The group.
        group: usize,
        /// Its number.
        found: u8,
    },
    /// A byte of a group that must be zero is not.
    Reserved {
        /// The group.
        group: usize,
    },
    /// A group without proxies, or with centres and neither inputs nor rank.
    EmptyGroup {
        /// The group.
        group: usize,
    },
    /// A group's fade does not start and then end within 0 and [`crate::format::CORRECTION_MAX`].
    Fade {
        /// The group.
        group: usize,
    },
    /// A group does not start where the one before it ends.
    GroupOffset {
        /// The group.
        group: usize,
        /// The word it should start at; `u32::MAX` also stands for more.
        expected: u32,
        /// The word it starts at.
        found: u32,
    },
    /// The groups' proxies are not those of the part.
    GroupProxies {
        /// Proxies of the part.
        expected: u32,
        /// Proxies of all groups; `u32::MAX` also stands for more.
        found: u32,
    },
    /// The part states another length of scratch than its groups need.
    Scratch {
        /// Floats that they need; `u32::MAX` also stands for more.
        expected: u32,
        /// Floats that it states.
        found: u32,
    },
    /// A vertex lies outside the rest box of a map that moves it.
    RestBox {
        /// The map's index in the palette.
        index: usize,
        /// The vertex.
        vertex: usize,
    },
}

/// Why a call was refused; nothing has been written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EvalError {
    /// An argument whose length must be exact has another.
    Length {
        /// The argument.
        argument: Argument,
        /// The length it must have, in its own elements.
        expected: usize,
        /// The length it has.
        found: usize,
    },
    /// A buffer is too short.
    TooShort {
        /// The argument.
        argument: Argument,
        /// The least length it must have, in its own elements; `usize::MAX` stands for more.
        least: usize,
        /// The length it has.
        found: usize,
    },
    /// The pose of a joint is not finite.
    NonFinite {
        /// The joint.
        joint: usize,
    },
    /// The rotation of a joint has no direction: its quaternion is zero, or too small or
    /// too large to square.
    ZeroRotation {
        /// The joint.
        joint: usize,
    },
    /// A range of vertices is not inside the mesh.
    VertexRange {
        /// First vertex.
        start: usize,
        /// One more than the last vertex.
        end: usize,
        /// Vertices of the mesh.
        vertex_len: usize,
    },
    /// An attribute's stride is shorter than the attribute.
    Stride {
        /// Floats of the attribute.
        least: usize,
        /// The stride, in floats.
        found: usize,
    },
    /// Tangents were asked of a model that has none.
    NoTangents,
    /// The stage is not part of the model's predictor.
    Predictor {
        /// The model's predictor.
        found: Predictor,
    },
}

/// The argument that an [`EvalError`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Argument {
    /// J skinning matrices or local transforms.
    Pose,
    /// Scratch, in floats.
    Workspace,
    /// The palette, in matrices.
    Palette,
    /// Columns of the joints' maps relative to the root.
    Relative,
    /// Rotation vectors of the joints.
    Rotations,
    /// Columns of the predicted gradients.
    Gradients,
    /// Pose features, in matrices.
    Features,
    /// Scratch of the correction, in floats.
    Scratch,
    /// Output buffer A, in floats.
    OutA,
    /// Output buffer B, in floats.
    OutB,
}

impl Argument {
    pub(crate) fn check_len(self, expected: usize, found: usize) -> Result<(), EvalError> {
        if found == expected {
            Ok(())
        } else {
            Err(EvalError::Length { argument: self, expected, found })
        }
    }

    pub(crate) fn check_least(self, least: usize, found: usize) -> Result<(), EvalError> {
        if found >= least {
            Ok(())
        } else {
            Err(EvalError::TooShort { argument: self, least, found })
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Workspace => "workspace",
            Self::Palette => "palette",
            Self::Relative => "relative maps",
            Self::Rotations => "rotations",
            Self::Gradients => "gradients",
            Self::Features => "features",
            Self::Scratch => "scratch",
            Self::OutA => "output a",
            Self::OutB => "output b",
        }
    }
}

impl core::error::Error for FormatError {}
impl core::error::Error for EvalError {}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Limit { quantity, most, found } => {
                write!(f, "{}: at most {most} allowed, found {found}", quantity.name())
            }
            Self::Malformed => f.write_str("the file ends early or states an impossible length"),
            Self::Magic { found } => write!(f, "not a model: it starts with {found:?}"),
            Self::Version { expected, found } => {
                write!(f, "format version: expected {expected}, found {found}")
            }
            Self::Checksum { expected, found } => {
                write!(f, "damaged file: expected checksum {expected:08x}, found {found:08x}")
            }
            Self::TrailingBytes { found } => write!(f, "{found} bytes follow the model's end"),
            Self::Features { unknown } => write!(f, "needs unknown features {unknown:#x}"),
            Self::Alignment { log2 } => {
                write!(f, "the blob is not aligned to 2^{log2}, or 2^{log2} is no alignment")
            }
            Self::Padding => f.write_str("padding is not zero"),
            Self::PartTable { bytes } => write!(f, "a part table of {bytes} bytes"),
            Self::SectionTable { bytes } => write!(f, "a section table of {bytes} bytes"),
            Self::Flags { found } => write!(f, "unknown flags {found:#x}"),
            Self::UnknownPart { kind } => write!(f, "unknown required part of kind {kind}"),
            Self::UnknownSection { kind } => write!(f, "unknown required section of kind {kind}"),
            Self::SectionPart { row, found } => {
                write!(f, "section row {row} belongs to part {found}, which is not there")
            }
            Self::SectionAlignment { row } => write!(f, "section row {row} is not aligned"),
            Self::SectionOverlap { row } => write!(f, "section row {row} starts inside another"),
            Self::SectionBounds { row } => write!(f, "section row {row} reaches beyond the blob"),
            Self::DuplicateSection { row } => write!(f, "section row {row} repeats a kind"),
            Self::Predictor { found } => write!(f, "unknown predictor {found}"),
            Self::Empty { quantity } => {
                write!(f, "{}: expected at least 1, found 0", quantity.name())
            }
            Self::MissingSection { section } => write!(f, "section {} is missing", section.name()),
            Self::UnexpectedSection { section } => {
                write!(f, "section {} is not of this predictor", section.name())
            }
            Self::SectionLength { section, expected, found } => {
                write!(f, "section {}: expected {expected} bytes, found {found}", section.name())
            }
            Self::Name { index } => write!(f, "name {index} is not valid"),
            Self::Hierarchy { joint } => write!(f, "joint {joint} is not part of one tree"),
            Self::Float { section, index } => write!(
                f,
                "float {index} of {} is out of range",
                section.map_or("the certificate", SectionKind::name)
            ),
            Self::Index { section, index, below, found } => write!(
                f,
                "index {index} of {}: expected less than {below}, found {found}",
                section.name()
            ),
            Self::Weights { vertex } => {
                write!(f, "the weights of vertex {vertex} do not sum to one")
            }
            Self::InverseBind { joint } => {
                write!(f, "the inverse bind matrix of joint {joint} is not rigid")
            }
            Self::Twist { key } => write!(f, "a twist matrix of key {key} is too large"),
            Self::Kernel { group, found } => write!(f, "group {group}: unknown kernel {found}"),
            Self::Reserved { group } => write!(f, "group {group}: a reserved byte is not zero"),
            Self::EmptyGroup { group } => {
                write!(f, "group {group} lacks proxies, or has centres but no inputs or no rank")
            }
            Self::Fade { group } => write!(f, "group {group}: the fade does not start and end"),
            Self::GroupOffset { group, expected, found } => {
                write!(f, "group {group}: expected at word {expected}, found at {found}")
            }
            Self::GroupProxies { expected, found } => {
                write!(f, "proxies of all groups: expected {expected}, found {found}")
            }
            Self::Scratch { expected, found } => {
                write!(f, "scratch: expected {expected} floats, found {found}")
            }
            Self::RestBox { index, vertex } => {
                write!(f, "vertex {vertex} lies outside the rest box of map {index}")
            }
        }
    }
}

impl fmt::Display for EvalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Length { argument, expected, found } => {
                write!(f, "{}: expected a length of {expected}, found {found}", argument.name())
            }
            Self::TooShort { argument, least, found } => write!(
                f,
                "{}: expected a length of at least {least}, found {found}",
                argument.name()
            ),
            Self::NonFinite { joint } => write!(f, "the pose of joint {joint} is not finite"),
            Self::ZeroRotation { joint } => {
                write!(f, "the rotation of joint {joint} is not a quaternion of finite length")
            }
            Self::VertexRange { start, end, vertex_len } => {
                write!(f, "vertices {start}..{end}: expected a range within 0..{vertex_len}")
            }
            Self::Stride { least, found } => {
                write!(f, "stride: expected at least {least} floats, found {found}")
            }
            Self::NoTangents => f.write_str("the model has no tangents"),
            Self::Predictor { found } => {
                write!(f, "predictor {} has no such stage", found.name())
            }
        }
    }
}
