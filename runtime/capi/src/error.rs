//! What went wrong, in numbers: no text is formatted, so that none need fit into small flash.

use crate::argument::sinew_argument;
use core::ffi::{CStr, c_char};
use sinew_runtime::{CallError, CallErrorKind, FileError, FileErrorKind};

/// Stands for no part.
pub const SINEW_NO_PART: u32 = u32::MAX;

/// What went wrong; written only when a call returns another status than `SINEW_STATUS_OK`.
///
/// Each status says which of the last three fields it fills; the others are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_error {
    /// What the call returned.
    pub status: sinew_status,
    /// The argument that it is about.
    pub argument: sinew_argument,
    /// The part of the file, or `SINEW_NO_PART`.
    pub part: u32,
    /// The section's number in FORMAT.md; 0 if it is about none.
    pub section: u32,
    /// Which element.
    pub index: usize,
    /// What should have been there: an exact value, the least or the most, as the status says.
    pub expected: usize,
    /// What was there.
    pub found: usize,
}

impl sinew_error {
    pub(crate) const fn new(status: sinew_status, argument: sinew_argument) -> Self {
        let (part, section) = (SINEW_NO_PART, 0);
        Self { status, argument, part, section, index: 0, expected: 0, found: 0 }
    }

    /// Makes the error of an index that must be below `len`.
    pub(crate) const fn beyond(argument: sinew_argument, index: usize, len: usize) -> Self {
        Self::new(sinew_status::OutOfRange, argument).values(len.saturating_sub(1), index)
    }

    pub(crate) const fn at(self, index: usize) -> Self {
        Self { index, ..self }
    }

    pub(crate) const fn values(self, expected: usize, found: usize) -> Self {
        Self { expected, found, ..self }
    }
}

impl From<CallError> for sinew_error {
    fn from(error: CallError) -> Self {
        let CallError { kind, argument, index, expected, found } = error;
        Self::new(kind.into(), argument.into()).at(index).values(expected, found)
    }
}

impl From<FileError> for sinew_error {
    fn from(error: FileError) -> Self {
        let FileError { kind, part, section, index, expected, found } = error;
        Self {
            part: part.map_or(SINEW_NO_PART, u32::from),
            section: section.map_or(0, |section| u32::from(section.number())),
            ..Self::new(kind.into(), sinew_argument::File)
                .at(index as usize)
                .values(expected as usize, found as usize)
        }
    }
}

/// What a call came to. 1 to 99: the call is wrong, from 50 on in what only C can get wrong. From 100
/// on: the file is.
///
/// `sinew_error` tells more: what an entry names as index, expected and found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(i32)]
pub enum sinew_status {
    /// Done.
    Ok = 0,

    /// An array whose length must be exact has another. Expected, found: lengths in its own elements.
    Length = 1,
    /// An array is too short. Expected: the least length; found: its length.
    TooShort = 2,
    /// A joint's transform, or a number of a query, is not finite. Index: the joint, of several poses counted
    /// through all; or the number. Of outputs, derivatives and variances: one would not be finite, for the
    /// query is too far out.
    NonFinite = 3,
    /// A quaternion has no direction: it is zero, or too small or too large to square. Index: the joint, or
    /// the input.
    ZeroRotation = 4,
    /// A joint, a vertex, a range of vertices, an input, an output or a distance is none that there may be.
    /// Index: which element, of a range its start; expected: the most; found: what it is, of a range its
    /// end.
    OutOfRange = 5,
    /// A stride is shorter than its attribute. Expected: floats of the attribute; found: the stride.
    Stride = 6,
    /// The skin has no such attribute, or the kernel no variance.
    NoAttribute = 7,
    /// The envelope's predictor has no such stage. Found: the predictor.
    NoStage = 8,
    /// A job has nothing to write to.
    NoOutput = 9,
    /// The skeleton lacks the root, which can follow no other joint. Index: the root.
    NoRoot = 10,
    /// The skeleton has a joint under a name of another prefix, case or separators. Index: the joint; found: the place
    /// of the skeleton's name.
    OtherName = 11,
    /// The skeleton has the root alone of several joints. Expected, found: joints.
    NoJoints = 12,

    /// A pointer is null.
    Null = 50,
    /// A pointer is not aligned for what it points to. Expected: bytes of alignment; found: bytes
    /// beyond the last multiple of it.
    Misaligned = 51,
    /// An array would reach beyond the address space. Found: its length.
    TooLong = 52,
    /// Memory to be written, which the argument names, overlaps other memory of the call, or an object
    /// or the file that the call reads.
    Overlap = 53,
    /// A handle points to no loaded object of its kind; of an envelope, a skin or a kernel also: its model
    /// is loaded no more, and then the argument is the model.
    NotLoaded = 54,
    /// The model of an envelope, a skin or a kernel has been loaded again, with another file: open it anew.
    Stale = 55,
    /// The file holds no such envelope, skin, kernel or section. Of a section part and section tell which.
    NotFound = 56,
    /// The skin has no vertices, and so no bounds.
    NoVertices = 57,

    /// Not a model: expected and found are the first four bytes, the first the least significant.
    FileNotAModel = 100,
    /// Written in a version of the format that this library does not know. Expected, found.
    FileVersion = 101,
    /// The file contradicts itself. Index 1 or 2: the part or the section table has no whole rows, and expected and
    /// found are bytes of a row and of the table; 3: they are the alignment of the blob, which follows zeros, and its place; 4: they are bytes of the file.
    FileMalformed = 102,
    /// The file was changed after it was written. Expected, found: its CRC-32.
    FileChecksum = 103,
    /// More of something than the limits or the format allow. Without a section index 0 is bytes of the
    /// file, 1 parts, 2 sections; else it is a count of the section. Expected: the most; found.
    FileLimit = 104,
    /// Something that this library does not know: feature bits; flags or the kind of a part or of a
    /// section; an element type, a predictor, a kernel, a reserved number that is not 0. Found: the
    /// number.
    FileUnsupported = 105,
    /// A section names a part that is not there. Index: its row; expected: how many there are; found:
    /// the part.
    FilePartIndex = 106,
    /// A section does not start on the alignment. Index: its row; expected: the alignment; found: its offset.
    FileAlignment = 107,
    /// A section starts before the one listed before it ends. Index: its row; expected: that end; found: its offset.
    FileOverlap = 108,
    /// A section reaches beyond the blob. Index: its row; expected: bytes of the blob; found: its end.
    FileBounds = 109,
    /// A part has two sections of one kind. Index: the second's row.
    FileDuplicate = 110,
    /// A part lacks the section.
    FileMissing = 111,
    /// A section that the part, as its counts describe it, does not have.
    FileUnexpected = 112,
    /// A section's length does not follow from the part's counts. Expected, found: bytes.
    FileLength = 113,
    /// There is none of what there must be at least one. Index: the count, or the group.
    FileEmpty = 114,
    /// A float is out of its range or not finite. Index: which of the section.
    FileFloat = 115,
    /// An index points beyond its target. Index: its place; expected: what it must be below; found.
    FileIndex = 116,
    /// A number does not follow from the rest of the file. Index: its place; expected, found.
    FileMismatch = 117,
    /// An element breaks a rule of its section, which FORMAT.md states. Index: the element.
    FileInvalid = 118,
    /// The file ends early. Expected, found: bytes of the section. Without a section they are bytes of the file, and
    /// index is the place of its end: 0 the head, 1 the part table, 2 the section table, 3 the padding, 4 the blob.
    FileTruncated = 119,
    /// A byte of the space is one that no space has. Index: which; found: the byte.
    FileSpace = 120,
}

/// What each status means, in a few words.
const TEXTS: [(sinew_status, &CStr); 42] = {
    use sinew_status as S;
    [
        (S::Ok, c"done"),
        (S::Length, c"an array has another length than it must have"),
        (S::TooShort, c"an array is too short"),
        (S::NonFinite, c"a transform or a number is not finite"),
        (S::ZeroRotation, c"a quaternion has no direction"),
        (S::OutOfRange, c"a number that counts, or a distance, is out of range"),
        (S::Stride, c"a stride, in floats, is shorter than its attribute"),
        (S::NoAttribute, c"the part has no such attribute"),
        (S::NoStage, c"the envelope's predictor has no such stage"),
        (S::NoOutput, c"there is nothing to write to"),
        (S::NoRoot, c"the skeleton lacks the root"),
        (S::OtherName, c"a joint's name has another prefix, case or separators in the skeleton"),
        (S::NoJoints, c"the skeleton has no joint but the root"),
        (S::Null, c"a pointer is null"),
        (S::Misaligned, c"a pointer is not aligned"),
        (S::TooLong, c"an array reaches beyond the address space"),
        (S::Overlap, c"memory to be written overlaps other memory of the call"),
        (S::NotLoaded, c"a handle points to no loaded object of its kind"),
        (S::Stale, c"the model holds another file than when this was opened"),
        (S::NotFound, c"the file holds no such part or section"),
        (S::NoVertices, c"the skin has no vertices"),
        (S::FileNotAModel, c"not a model"),
        (S::FileVersion, c"unknown version of the format"),
        (S::FileMalformed, c"the file states something impossible"),
        (S::FileChecksum, c"damaged file"),
        (S::FileLimit, c"more than the limits or the format allow"),
        (S::FileUnsupported, c"the file needs something that this library does not know"),
        (S::FilePartIndex, c"a section belongs to a part that is not there"),
        (S::FileAlignment, c"a section is not aligned"),
        (S::FileOverlap, c"a section starts inside another"),
        (S::FileBounds, c"a section reaches beyond the blob"),
        (S::FileDuplicate, c"a part has two sections of one kind"),
        (S::FileMissing, c"a section is missing"),
        (S::FileUnexpected, c"a section is not one of its part's"),
        (S::FileLength, c"a section has another length than the counts give"),
        (S::FileEmpty, c"there is none of what there must be at least one"),
        (S::FileFloat, c"a float is out of range"),
        (S::FileIndex, c"an index is out of range"),
        (S::FileMismatch, c"a number does not follow from the rest of the file"),
        (S::FileInvalid, c"an element breaks a rule of its section"),
        (S::FileTruncated, c"the file ends early"),
        (S::FileSpace, c"the file's space is none"),
    ]
};

/// Returns what a status means, in a few words that end in a zero; of any other number, that it is
/// unknown. Never null, valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_status_text(status: i32) -> *const c_char {
    let found = TEXTS.iter().find(|(known, _)| *known as i32 == status);
    found.map_or(c"unknown status", |(_, text)| text).as_ptr()
}

impl From<CallErrorKind> for sinew_status {
    fn from(kind: CallErrorKind) -> Self {
        match kind {
            CallErrorKind::Length => Self::Length,
            CallErrorKind::TooShort => Self::TooShort,
            CallErrorKind::NonFinite => Self::NonFinite,
            CallErrorKind::ZeroRotation => Self::ZeroRotation,
            CallErrorKind::OutOfRange => Self::OutOfRange,
            CallErrorKind::Stride => Self::Stride,
            CallErrorKind::NoAttribute => Self::NoAttribute,
            CallErrorKind::NoStage => Self::NoStage,
            CallErrorKind::NoOutput => Self::NoOutput,
            CallErrorKind::NoRoot => Self::NoRoot,
            CallErrorKind::OtherName => Self::OtherName,
            CallErrorKind::NoJoints => Self::NoJoints,
        }
    }
}

impl From<FileErrorKind> for sinew_status {
    fn from(kind: FileErrorKind) -> Self {
        match kind {
            FileErrorKind::NotAModel => Self::FileNotAModel,
            FileErrorKind::Version => Self::FileVersion,
            FileErrorKind::Malformed => Self::FileMalformed,
            FileErrorKind::Truncated => Self::FileTruncated,
            FileErrorKind::Space => Self::FileSpace,
            FileErrorKind::Checksum => Self::FileChecksum,
            FileErrorKind::Limit => Self::FileLimit,
            FileErrorKind::Unsupported => Self::FileUnsupported,
            FileErrorKind::PartIndex => Self::FilePartIndex,
            FileErrorKind::Alignment => Self::FileAlignment,
            FileErrorKind::Overlap => Self::FileOverlap,
            FileErrorKind::Bounds => Self::FileBounds,
            FileErrorKind::Duplicate => Self::FileDuplicate,
            FileErrorKind::Missing => Self::FileMissing,
            FileErrorKind::Unexpected => Self::FileUnexpected,
            FileErrorKind::Length => Self::FileLength,
            FileErrorKind::Empty => Self::FileEmpty,
            FileErrorKind::Float => Self::FileFloat,
            FileErrorKind::Index => Self::FileIndex,
            FileErrorKind::Mismatch => Self::FileMismatch,
            FileErrorKind::Invalid => Self::FileInvalid,
        }
    }
}
