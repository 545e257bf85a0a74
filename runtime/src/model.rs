//! A loaded file: what it holds, by kind and by name.

use crate::envelope::Envelope;
use crate::error::FormatError;
use crate::format::{Manifest, PartKind, PartRow, SectionRow};
use crate::limits::Limits;
use core::fmt;

/// A validated model, borrowed from its bytes: copy it freely, share it between threads.
#[derive(Clone, Copy)]
pub struct Model<'a> {
    manifest: Manifest<'a>,
}

/// One section of a file, known to this reader or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// Its row in the section table; `row.part` indexes [`Model::parts`].
    pub row: SectionRow,
    /// Its content.
    pub bytes: &'a [u8],
}

impl<'a> Model<'a> {
    /// Loads a model in place, within the default [`Limits`].
    ///
    /// # Errors
    /// See [`Model::from_bytes_with`].
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
        Self::from_bytes_with(bytes, &Limits::DEFAULT)
    }

    /// Loads a model in place and checks all of it, in the order that FORMAT.md lists and
    /// in time bounded by the file's length. Never panics, for any input.
    ///
    /// `bytes` needs no alignment.
    ///
    /// # Errors
    /// Every variant of [`FormatError`]; each says what makes it.
    pub fn from_bytes_with(bytes: &'a [u8], limits: &Limits) -> Result<Self, FormatError> {
        Ok(Self { manifest: crate::format::read(bytes, limits)? })
    }

    /// Returns the first envelope.
    pub fn envelope(&self) -> Option<Envelope<'a>> {
        self.envelopes().next()
    }

    /// Returns the envelope of this name.
    pub fn envelope_named(&self, name: &str) -> Option<Envelope<'a>> {
        self.envelopes().find(|envelope| envelope.name() == name)
    }

    /// Lists the parts, unknown ones included.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = PartRow> + use<'a> {
        self.manifest.parts.iter().map(PartRow::from_bytes)
    }

    /// Lists the sections, unknown ones included, in the order of the file.
    pub fn sections(&self) -> impl ExactSizeIterator<Item = Section<'a>> + use<'a> {
        let manifest = self.manifest;
        manifest.rows().map(move |row| Section { row, bytes: manifest.bytes(row) })
    }

    /// Returns the blob: all sections, at the offsets that their rows state. What a GPU is given.
    pub fn blob(&self) -> &'a [u8] {
        self.manifest.blob
    }

    fn envelopes(self) -> impl Iterator<Item = Envelope<'a>> + use<'a> {
        self.parts().enumerate().filter_map(move |(part, row)| {
            if row.kind != PartKind::Envelope.number() {
                return None;
            }
            Envelope::view(&self.manifest, part, &row)
        })
    }
}

impl fmt::Debug for Model<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.parts()).finish()
    }
}
