//! What went wrong, in numbers: no text is formatted, so that none need fit into small flash.

use crate::argument::sinew_argument;
use crate::status::sinew_status;
use sinew_runtime::{CallError, FileError};

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
