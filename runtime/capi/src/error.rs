//! Statuses and errors. They are numbers without formatted text, so that they fit into small flash.

use crate::argument::sinew_argument;
use core::ffi::{CStr, c_char};
use sinew_runtime::{CallError, CallErrorKind, FileError, FileErrorKind};

/// Sentinel for "no part".
pub const SINEW_NO_PART: u32 = u32::MAX;

/// Why a call failed, in numbers. A call writes the error only if its status is not `SINEW_STATUS_OK`.
///
/// The comment of each status lists which of the last three fields the status fills; the other fields are
/// 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_error {
    /// Status that the call returned.
    pub status: sinew_status,
    /// Argument that the error is about.
    pub argument: sinew_argument,
    /// Part of the file, or `SINEW_NO_PART`.
    pub part: u32,
    /// Number of the section in FORMAT.md; 0 if the error is not about a section.
    pub section: u32,
    /// Index of the element.
    pub index: usize,
    /// Expected value: the exact value, the minimum or the maximum, as the status says.
    pub expected: usize,
    /// Value that was found.
    pub found: usize,
}

impl sinew_error {
    pub(crate) const fn new(status: sinew_status, argument: sinew_argument) -> Self {
        let (part, section) = (SINEW_NO_PART, 0);
        Self { status, argument, part, section, index: 0, expected: 0, found: 0 }
    }

    /// Makes the error of an index that must be below `len`.
    pub(crate) const fn out_of_range(argument: sinew_argument, index: usize, len: usize) -> Self {
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

/// Result of a call. From 1 to 49 the call is wrong, from 50 to 99 its pointers or handles are, from 100 on
/// the file is.
///
/// The comments list the fields of `sinew_error` that each status fills: index, expected and found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(i32)]
pub enum sinew_status {
    /// Success.
    Ok = 0,

    /// An array does not have the exact length that is required. Expected, found: lengths in the array's
    /// elements.
    Length = 1,
    /// An array is too short. Expected: the minimum length; found: the array's length.
    TooShort = 2,
    /// A transform of a joint, a curve or a number of a query is not finite. Index: the joint or the curve,
    /// counted through all poses of a batch, or the number. For outputs, derivatives and variances: the
    /// result would not be finite, because the query is too far from the centres.
    NonFinite = 3,
    /// A quaternion has no direction: it is zero, or its square underflows or overflows. Index: the joint
    /// or the input.
    ZeroRotation = 4,
    /// An index, a range of vertices or a distance is out of range. Index: the element, or the start of the
    /// range; expected: the maximum; found: the value, or the end of the range.
    OutOfRange = 5,
    /// A stride is shorter than its attribute. Expected: floats of the attribute; found: the stride.
    Stride = 6,
    /// The skin does not have the attribute, or the kernel has no variance.
    NoAttribute = 7,
    /// The envelope's predictor does not have the stage. Found: the predictor.
    NoStage = 8,
    /// A job has no output to write.
    NoOutput = 9,
    /// The skeleton lacks the root, which has no parent to follow. Index: the root.
    NoRoot = 10,
    /// A joint's name has another prefix, case or separators in the skeleton. Index: the joint; found: the
    /// index of the skeleton's name.
    OtherName = 11,
    /// The skeleton has only the root of several joints. Expected, found: numbers of joints.
    NoJoints = 12,
    /// The caller's names lack a curve of the file. Index: the curve.
    NoCurve = 13,

    /// A pointer is null.
    Null = 50,
    /// A pointer is not aligned for its type. Expected: the alignment in bytes; found: the remainder in
    /// bytes.
    Misaligned = 51,
    /// An array would reach outside the address space. Found: its length.
    TooLong = 52,
    /// Output memory, named by the argument, overlaps other memory of the call: another array, an object,
    /// or the file.
    Overlap = 53,
    /// A handle points to no loaded object of its kind. If a part's model was cleared, the argument is the
    /// model.
    NotLoaded = 54,
    /// The part's model has loaded another file: open the part again.
    Stale = 55,
    /// The file has no part with this name and index, or no such section. For a section, the error names
    /// its part and kind.
    NotFound = 56,
    /// The skin has no vertices, and therefore no bounds.
    NoVertices = 57,

    /// The file is not a model. Expected, found: the first four bytes, as a little-endian number.
    FileNotAModel = 100,
    /// The file has a version of the format that this library does not know. Expected, found: versions.
    FileVersion = 101,
    /// The file contradicts itself. Index 1 or 2: the part table or the section table does not consist of
    /// whole rows; expected: bytes of a row; found: bytes of the table. Index 3: the blob is not aligned or
    /// does not follow zeros; expected: the alignment; found: the blob's offset. Index 4: the file does not
    /// end with the blob; expected, found: bytes of the file.
    FileMalformed = 102,
    /// The file was changed after it was written. Expected, found: CRC-32.
    FileChecksum = 103,
    /// A count exceeds the limits or the format. Without a section, index 0 is bytes of the file, 1 parts,
    /// 2 sections; with a section, the index is the count's position in the section. Expected: the maximum;
    /// found: the count.
    FileLimit = 104,
    /// This library does not know a feature bit, a flag, a kind of part or section, an element type, a
    /// predictor or a kernel, or a reserved number is not 0. Found: the number.
    FileUnsupported = 105,
    /// A section names a part that does not exist. Index: the section's row; expected: the number of parts;
    /// found: the named part.
    FilePartIndex = 106,
    /// A section is not aligned. Index: its row; expected: the alignment; found: its offset.
    FileAlignment = 107,
    /// A section starts before the end of the section listed before it. Index: its row; expected: that end;
    /// found: its offset.
    FileOverlap = 108,
    /// A section ends outside the blob. Index: its row; expected: bytes of the blob; found: its end.
    FileBounds = 109,
    /// A part has two sections of one kind. Index: the row of the second section.
    FileDuplicate = 110,
    /// A part lacks the section.
    FileMissing = 111,
    /// The part has a section that its counts do not allow.
    FileUnexpected = 112,
    /// A section's length does not match the part's counts. Expected, found: bytes.
    FileLength = 113,
    /// A count that must be at least 1 is 0. Index: the count or the group.
    FileEmpty = 114,
    /// A float is out of range or not finite. Index: its position in the section.
    FileFloat = 115,
    /// An index points outside its target. Index: its position; expected: the bound that it must be below;
    /// found: the index.
    FileIndex = 116,
    /// A number does not match the rest of the file. Index: its position; expected, found: numbers.
    FileMismatch = 117,
    /// An element breaks a rule of its section in FORMAT.md. Index: the element.
    FileInvalid = 118,
    /// The file ends early. Expected, found: bytes of the section. Without a section they are bytes of the
    /// file, and the index names where it ends: 0 the head, 1 the part table, 2 the section table, 3 the
    /// padding, 4 the blob.
    FileTruncated = 119,
    /// A byte of the space (axes, handedness, unit) is not valid. Index: the byte's position; found: the
    /// byte.
    FileSpace = 120,
}

/// Text of each status, and the fields that it fills: i for index, e for expected, f for found.
const TEXTS: [(sinew_status, &CStr, &str); 43] = {
    use sinew_status as S;
    [
        (S::Ok, c"done", ""),
        (S::Length, c"an array has the wrong length", "ef"),
        (S::TooShort, c"an array is too short", "ef"),
        (S::NonFinite, c"a transform or a number is not finite", "i"),
        (S::ZeroRotation, c"a quaternion has no direction", "i"),
        (S::OutOfRange, c"an index, a range or a distance is out of range", "ief"),
        (S::Stride, c"a stride, in floats, is shorter than its attribute", "ef"),
        (S::NoAttribute, c"the part has no such attribute", ""),
        (S::NoStage, c"the envelope's predictor has no such stage", "f"),
        (S::NoOutput, c"the job has no output", ""),
        (S::NoRoot, c"the skeleton lacks the root", "i"),
        (
            S::OtherName,
            c"a joint's name has another prefix, case or separators in the skeleton",
            "if",
        ),
        (S::NoJoints, c"the skeleton has no joint but the root", "ef"),
        (S::NoCurve, c"the names lack a curve of the file", "i"),
        (S::Null, c"a pointer is null", ""),
        (S::Misaligned, c"a pointer is not aligned", "ef"),
        (S::TooLong, c"an array reaches outside the address space", "f"),
        (S::Overlap, c"output memory overlaps other memory of the call", ""),
        (S::NotLoaded, c"a handle points to no loaded object of its kind", ""),
        (S::Stale, c"the model has loaded another file since the part was opened", ""),
        (S::NotFound, c"the file holds no such part or section", ""),
        (S::NoVertices, c"the skin has no vertices", ""),
        (S::FileNotAModel, c"not a model", "ef"),
        (S::FileVersion, c"unknown version of the format", "ef"),
        (S::FileMalformed, c"the file contradicts itself", "ief"),
        (S::FileChecksum, c"the file is damaged", "ef"),
        (S::FileLimit, c"a count exceeds the limits or the format", "ief"),
        (S::FileUnsupported, c"the file needs something that this library does not know", "f"),
        (S::FilePartIndex, c"a section belongs to a part that does not exist", "ief"),
        (S::FileAlignment, c"a section is not aligned", "ief"),
        (S::FileOverlap, c"a section starts inside another", "ief"),
        (S::FileBounds, c"a section ends outside the blob", "ief"),
        (S::FileDuplicate, c"a part has two sections of one kind", "i"),
        (S::FileMissing, c"a section is missing", ""),
        (S::FileUnexpected, c"the part may not have this section", ""),
        (S::FileLength, c"a section's length does not match the counts", "ef"),
        (S::FileEmpty, c"a count that must be at least 1 is 0", "i"),
        (S::FileFloat, c"a float is out of range", "i"),
        (S::FileIndex, c"an index is out of range", "ief"),
        (S::FileMismatch, c"a number does not match the rest of the file", "ief"),
        (S::FileInvalid, c"an element breaks a rule of its section", "i"),
        (S::FileTruncated, c"the file ends early", "ief"),
        (S::FileSpace, c"the file's axes, handedness or unit are not valid", "if"),
    ]
};

/// Returns the meaning of a status as zero-terminated text. Other numbers give "unknown status". The
/// pointer is never null and stays valid.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_status_text(status: i32) -> *const c_char {
    let found = TEXTS.iter().find(|(known, ..)| *known as i32 == status);
    found.map_or(c"unknown status", |(_, text, _)| text).as_ptr()
}

/// Writes an error as zero-terminated text: the argument, the meaning of the status, and the fields that the
/// status fills, for example "pose: an array has the wrong length, expected 53, found 12".
///
/// - `error`: an error that a call wrote; null gives an empty text.
/// - `out_text`, `text_len`: receives the text, cut off to `text_len` bytes with the zero; null and 0 if only
///   the length is wanted.
///
/// Returns the length of the whole text in bytes, without the zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_error_text(
    error: *const sinew_error,
    out_text: *mut c_char,
    text_len: usize,
) -> usize {
    // SAFETY: null, or one error of the caller.
    let error = unsafe { error.as_ref() };
    let out = if out_text.is_null() { core::ptr::NonNull::dangling().as_ptr() } else { out_text };
    let text_len = if out_text.is_null() { 0 } else { text_len };
    // SAFETY: the caller lends this memory.
    let out = unsafe { core::slice::from_raw_parts_mut(out.cast::<u8>(), text_len) };
    let mut text = Text { out, len: 0 };
    if let Some(error) = error {
        error.write(&mut text);
    }
    let Text { out, len } = text;
    if let Some(last) = out.len().checked_sub(1)
        && let Some(zero) = out.get_mut(len.min(last))
    {
        *zero = 0;
    }
    len
}

/// Memory that receives a text, and the length of the text so far.
struct Text<'a> {
    out: &'a mut [u8],
    len: usize,
}

impl Text<'_> {
    fn push(&mut self, text: &[u8]) {
        let room = self.out.get_mut(self.len..).unwrap_or_default();
        room.iter_mut().zip(text).for_each(|(out, byte)| *out = *byte);
        self.len = self.len.saturating_add(text.len());
    }

    /// Writes a number. `core::fmt` would add its panics to firmware.
    fn push_number(&mut self, mut number: usize) {
        let (mut digits, mut len) = ([0; 20], 0);
        for digit in digits.iter_mut().rev() {
            *digit = b'0' + (number % 10) as u8;
            (number, len) = (number / 10, len + 1);
            if number == 0 {
                break;
            }
        }
        self.push(digits.get(digits.len() - len..).unwrap_or_default());
    }

    fn push_field(&mut self, name: &str, value: usize) {
        self.push(b", ");
        self.push(name.as_bytes());
        self.push(b" ");
        self.push_number(value);
    }
}

impl sinew_error {
    fn write(&self, out: &mut Text<'_>) {
        let Self { status, argument, part, section, index, expected, found } = *self;
        let known = TEXTS.iter().find(|(known, ..)| *known == status);
        let (text, fields) = known.map_or((c"", ""), |(_, text, fields)| (*text, *fields));
        out.push(argument.name().as_bytes());
        out.push(b": ");
        out.push(text.to_bytes());
        if part != SINEW_NO_PART {
            out.push_field("part", part as usize);
        }
        if section != 0 {
            out.push_field("section", section as usize);
        }
        for (letter, name, value) in
            [(b'i', "index", index), (b'e', "expected", expected), (b'f', "found", found)]
        {
            if fields.bytes().any(|own| own == letter) {
                out.push_field(name, value);
            }
        }
    }
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
            CallErrorKind::Overlap => Self::Overlap,
            CallErrorKind::NoAttribute => Self::NoAttribute,
            CallErrorKind::NoStage => Self::NoStage,
            CallErrorKind::NoOutput => Self::NoOutput,
            CallErrorKind::NoRoot => Self::NoRoot,
            CallErrorKind::OtherName => Self::OtherName,
            CallErrorKind::NoJoints => Self::NoJoints,
            CallErrorKind::NoCurve => Self::NoCurve,
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
