//! The state of a load, and how a check reports an error. The loader is `model.rs`.

use super::error::{FileError, FileErrorKind, saturated};
use super::sections::SectionKind;
use crate::limits::Limits;
use core::cell::Cell;

/// A file that is being loaded, with the error of the check that failed.
pub(crate) struct Loading<'a> {
    pub(crate) file: &'a [u8],
    pub(crate) limits: &'a Limits,
    /// Part under check.
    part: Cell<Option<u16>>,
    error: Cell<FileError>,
}

/// Marker that the file is refused; [`Loading`] holds the reason. A result with the reason inside
/// would be copied on its way out of every check; this marker costs a branch.
#[derive(Debug)]
pub(crate) struct Refused;

/// Result of a check.
pub(crate) type Checked<T = ()> = Result<T, Refused>;

impl<'a> Loading<'a> {
    /// Starts loading a file.
    pub(crate) const fn new(file: &'a [u8], limits: &'a Limits) -> Self {
        let kind = FileErrorKind::Truncated;
        let nothing =
            FileError { kind, part: None, section: None, index: 0, expected: 0, found: 0 };
        Self { file, limits, part: Cell::new(None), error: Cell::new(nothing) }
    }

    /// Sets the part of the checks that follow.
    #[inline(never)]
    pub(crate) fn of_part(&self, part: u16) {
        self.part.set(Some(part));
    }

    /// Refuses the file, and records the section, element and values.
    #[cold]
    #[inline(never)]
    pub(crate) fn refuse(
        &self,
        kind: FileErrorKind,
        section: Option<SectionKind>,
        index: usize,
        [expected, found]: [u32; 2],
    ) -> Refused {
        let index = saturated(index as u64);
        self.error.set(FileError { kind, part: None, section, index, expected, found });
        Refused
    }

    /// Refuses an element that breaks a rule of its section.
    #[cold]
    #[inline(never)]
    pub(crate) fn invalid(&self, section: SectionKind, index: usize) -> Checked {
        Err(self.refuse(FileErrorKind::Invalid, Some(section), index, [0; 2]))
    }

    /// Returns the reason for the refusal.
    pub(crate) const fn error(self) -> FileError {
        FileError { part: self.part.into_inner(), ..self.error.into_inner() }
    }
}
