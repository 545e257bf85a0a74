//! What every check of a load is given, and where it says what is wrong. The loader is `model.rs`.

use super::error::{FileError, FileErrorKind, saturated};
use super::sections::SectionKind;
use crate::limits::Limits;
use core::cell::Cell;

/// A file that is being loaded: what every check needs, and what the one that failed has to say.
pub(crate) struct Loading<'a> {
    pub(crate) file: &'a [u8],
    pub(crate) limits: &'a Limits,
    /// The part that the checks are of.
    part: Cell<Option<u16>>,
    error: Cell<FileError>,
}

/// The file is refused, and [`Loading`] knows why. A result that carried the reason would be copied on
/// its way out of every check; this one costs a branch.
#[derive(Debug)]
pub(crate) struct Refused;

/// What comes of a check.
pub(crate) type Checked<T = ()> = Result<T, Refused>;

impl<'a> Loading<'a> {
    /// Starts to load a file.
    pub(crate) const fn new(file: &'a [u8], limits: &'a Limits) -> Self {
        let kind = FileErrorKind::Truncated;
        let nothing =
            FileError { kind, part: None, section: None, index: 0, expected: 0, found: 0 };
        Self { file, limits, part: Cell::new(None), error: Cell::new(nothing) }
    }

    /// Says which part the checks that follow are of.
    #[inline(never)]
    pub(crate) fn of_part(&self, part: u16) {
        self.part.set(Some(part));
    }

    /// Refuses the file, and says of which section, element and values.
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
    pub(crate) fn invalid(&self, section: SectionKind, index: usize) -> Checked {
        Err(self.refuse(FileErrorKind::Invalid, Some(section), index, [0; 2]))
    }

    /// Returns why the file was refused.
    pub(crate) const fn error(self) -> FileError {
        FileError { part: self.part.into_inner(), ..self.error.into_inner() }
    }
}
