//! What every function returns.

use core::ffi::{CStr, c_char};

/// What a call came to. 1 to 99: the call is wrong. From 100 on: the file is.
///
/// `sinew_error` tells more: what an entry names as subject, index, expected and found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(i32)]
pub enum sinew_status {
    /// Done.
    Ok = 0,

    /// A pointer is null. Subject: the argument.
    Null = 1,
    /// A pointer is not aligned for what it points to. Subject: the argument; expected: bytes of
    /// alignment; found: bytes beyond the last multiple of it.
    Misaligned = 2,
    /// An array would reach beyond the address space. Subject: the argument; found: its length.
    TooLong = 3,
    /// Memory to be written overlaps other memory of the call, or the object or the file that the
    /// call reads. Subject: the argument to be written.
    Overlap = 4,
    /// A handle points to no loaded object of its kind. Subject: the argument.
    NotLoaded = 5,
    /// An array whose length must be exact has another. Subject: the array; expected, found:
    /// lengths in its own elements.
    Length = 6,
    /// An array is too short. Subject: the array; expected: the least length; found: its length.
    TooShort = 7,
    /// A joint, or a range of vertices, is not in the model. Subject: joints or vertices; index: the
    /// joint, or the range's start; expected: how many there are; found: the joint, or the range's end.
    OutOfRange = 8,
    /// The pose of a joint is not finite. Subject: the argument; index: the joint.
    NonFinite = 9,
    /// A joint's quaternion has no direction: it is zero, or too small or too large to square.
    /// Subject: the argument; index: the joint.
    ZeroRotation = 10,
    /// A stride is shorter than its attribute. Expected: floats of the attribute; found: the stride.
    Stride = 11,
    /// An attribute names no buffer. Subject: the attribute; found: the number in the buffer's place.
    Buffer = 12,
    /// Tangents were asked of a model that has none. Subject: tangents.
    NoTangents = 13,
    /// The model has no vertices, and so no bounds. Subject: vertices.
    NoVertices = 14,
    /// The file holds no such envelope, or no such section. Subject: the envelope, or the section if it
    /// is one of FORMAT.md's; found: the section's number.
    NotFound = 15,
    /// The model's predictor has no such stage. Found: the predictor.
    NoStage = 16,

    /// More than the limits or the format allow. Subject: of what; expected: the most; found.
    Limit = 100,
    /// The file ends early, or a length in it is no length.
    Malformed = 101,
    /// Not a model: expected and found are the first four bytes, the first the least significant.
    Magic = 102,
    /// Written in a version of the format that this library does not know. Expected, found.
    Version = 103,
    /// The file was changed after it was written. Expected, found: its CRC-32.
    Checksum = 104,
    /// Bytes follow the model's end. Found: how many.
    TrailingBytes = 105,
    /// The file needs features that this library does not have. Found: their bits.
    Features = 106,
    /// The blob's alignment is none, or the blob does not start on it. Found: its power of two.
    Alignment = 107,
    /// Padding that is not zero.
    Padding = 108,
    /// The part table has no whole number of rows, or too many or none. Found: its bytes.
    PartTable = 109,
    /// The section table has no whole number of rows, or too many. Found: its bytes.
    SectionTable = 110,
    /// A row states flags that this version does not have. Found: the flags.
    Flags = 111,
    /// A part that a reader must know and this one does not. Found: its kind.
    UnknownPart = 112,
    /// A section that a reader must know and this one does not. Found: its kind.
    UnknownSection = 113,
    /// A section names a part that is not there. Index: its row; found: the part.
    SectionPart = 114,
    /// A section does not start on the file's alignment. Index: its row.
    SectionAlignment = 115,
    /// A section starts before the one listed before it ends. Index: its row.
    SectionOverlap = 116,
    /// A section reaches beyond the blob. Index: its row.
    SectionBounds = 117,
    /// A part has two sections of one kind. Index: the second's row.
    DuplicateSection = 118,
    /// A predictor that this library does not know. Found: its number.
    Predictor = 119,
    /// There is none of what there must be at least one. Subject: of what; expected: 1.
    Empty = 120,
    /// A part lacks a section. Subject: the section.
    MissingSection = 121,
    /// A section that the part's predictor does not have. Subject: the section.
    UnexpectedSection = 122,
    /// A section's length does not follow from the part's counts. Subject: the section; expected,
    /// found: bytes.
    SectionLength = 123,
    /// A name is not UTF-8, or its place is wrong. Index: 0 the part's, 1 + j that of joint j.
    Name = 124,
    /// A parent or the evaluation order is not that of one tree. Index: the joint.
    Hierarchy = 125,
    /// A float is out of its range or not finite. Subject: its section or the certificate; index.
    Float = 126,
    /// An index points beyond its target. Subject: its section; index: its place; expected: what it
    /// must be below; found.
    Index = 127,
    /// The weights of a vertex do not sum to one. Index: the vertex.
    Weights = 128,
    /// A twist matrix is too large. Index: its key.
    Twist = 129,
    /// A kernel that this library does not know. Index: its group; found: its number.
    Kernel = 130,
    /// A byte of a group that must be zero is not. Index: the group.
    Reserved = 131,
    /// A group without proxies, or with centres and neither inputs nor rank. Index: the group.
    EmptyGroup = 132,
    /// A group's fade does not start and then end in its range. Index: the group.
    Fade = 133,
    /// A group does not start where the one before it ends. Index: the group; expected, found: words.
    GroupOffset = 134,
    /// The groups' proxies are not those of the part. Expected, found.
    GroupProxies = 135,
    /// The part states another length of scratch than its groups need. Expected, found: floats.
    Scratch = 136,
    /// A vertex lies outside the rest box of a map that moves it. Index: the map; found: the vertex.
    RestBox = 137,
    /// An inverse bind matrix is no rigid motion. Index: the joint.
    InverseBind = 138,
}

impl sinew_status {
    /// Returns what it means, in a few words.
    pub const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Null => c"a pointer is null",
            Self::Misaligned => c"a pointer is not aligned",
            Self::TooLong => c"an array reaches beyond the address space",
            Self::Overlap => c"memory to be written overlaps other memory of the call",
            Self::NotLoaded => c"a handle points to no loaded object of its kind",
            Self::Length => c"an array has another length than it must have",
            Self::TooShort => c"an array is too short",
            Self::OutOfRange => c"a joint or vertex is not in the model",
            Self::NonFinite => c"the pose of a joint is not finite",
            Self::ZeroRotation => c"the quaternion of a joint has no direction",
            Self::Stride => c"a stride is shorter than its attribute",
            Self::Buffer => c"an attribute names no buffer",
            Self::NoTangents => c"the model has no tangents",
            Self::NoVertices => c"the model has no vertices",
            Self::NotFound => c"the file holds no such envelope or section",
            Self::NoStage => c"the model's predictor has no such stage",
            Self::Limit => c"more than the limits or the format allow",
            Self::Malformed => c"the file ends early or states an impossible length",
            Self::Magic => c"not a model",
            Self::Version => c"unknown version of the format",
            Self::Checksum => c"damaged file",
            Self::TrailingBytes => c"bytes follow the model's end",
            Self::Features => c"the file needs unknown features",
            Self::Alignment => c"the blob is not aligned, or states no alignment",
            Self::Padding => c"padding is not zero",
            Self::PartTable => c"the part table has an impossible length",
            Self::SectionTable => c"the section table has an impossible length",
            Self::Flags => c"unknown flags",
            Self::UnknownPart => c"unknown required part",
            Self::UnknownSection => c"unknown required section",
            Self::SectionPart => c"a section belongs to a part that is not there",
            Self::SectionAlignment => c"a section is not aligned",
            Self::SectionOverlap => c"a section starts inside another",
            Self::SectionBounds => c"a section reaches beyond the blob",
            Self::DuplicateSection => c"a part has two sections of one kind",
            Self::Predictor => c"unknown predictor",
            Self::Empty => c"there is none of what there must be at least one",
            Self::MissingSection => c"a section is missing",
            Self::UnexpectedSection => c"a section is not of the part's predictor",
            Self::SectionLength => c"a section has another length than the counts give",
            Self::Name => c"a name is not valid",
            Self::Hierarchy => c"a joint is not part of one tree",
            Self::Float => c"a float is out of range",
            Self::Index => c"an index is out of range",
            Self::Weights => c"the weights of a vertex do not sum to one",
            Self::Twist => c"a twist matrix is too large",
            Self::Kernel => c"unknown kernel",
            Self::Reserved => c"a reserved byte is not zero",
            Self::EmptyGroup => c"a group lacks proxies, inputs or rank",
            Self::Fade => c"a group's fade does not start and then end",
            Self::GroupOffset => c"a group does not start where the one before it ends",
            Self::GroupProxies => c"the groups' proxies are not those of the part",
            Self::Scratch => c"the part states another length of scratch than it needs",
            Self::RestBox => c"a vertex lies outside the rest box of a map",
            Self::InverseBind => c"an inverse bind matrix is not rigid",
        }
    }
}

/// Returns what a status means, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_status_text(status: i32) -> *const c_char {
    const ALL: [sinew_status; 56] = [
        sinew_status::Ok,
        sinew_status::Null,
        sinew_status::Misaligned,
        sinew_status::TooLong,
        sinew_status::Overlap,
        sinew_status::NotLoaded,
        sinew_status::Length,
        sinew_status::TooShort,
        sinew_status::OutOfRange,
        sinew_status::NonFinite,
        sinew_status::ZeroRotation,
        sinew_status::Stride,
        sinew_status::Buffer,
        sinew_status::NoTangents,
        sinew_status::NoVertices,
        sinew_status::NotFound,
        sinew_status::NoStage,
        sinew_status::Limit,
        sinew_status::Malformed,
        sinew_status::Magic,
        sinew_status::Version,
        sinew_status::Checksum,
        sinew_status::TrailingBytes,
        sinew_status::Features,
        sinew_status::Alignment,
        sinew_status::Padding,
        sinew_status::PartTable,
        sinew_status::SectionTable,
        sinew_status::Flags,
        sinew_status::UnknownPart,
        sinew_status::UnknownSection,
        sinew_status::SectionPart,
        sinew_status::SectionAlignment,
        sinew_status::SectionOverlap,
        sinew_status::SectionBounds,
        sinew_status::DuplicateSection,
        sinew_status::Predictor,
        sinew_status::Empty,
        sinew_status::MissingSection,
        sinew_status::UnexpectedSection,
        sinew_status::SectionLength,
        sinew_status::Name,
        sinew_status::Hierarchy,
        sinew_status::Float,
        sinew_status::Index,
        sinew_status::Weights,
        sinew_status::Twist,
        sinew_status::Kernel,
        sinew_status::Reserved,
        sinew_status::EmptyGroup,
        sinew_status::Fade,
        sinew_status::GroupOffset,
        sinew_status::GroupProxies,
        sinew_status::Scratch,
        sinew_status::RestBox,
        sinew_status::InverseBind,
    ];
    let found = ALL.into_iter().find(|known| *known as i32 == status);
    found.map_or(c"unknown status", sinew_status::text).as_ptr()
}
