//! The lists of names that Alembic keeps behind its objects and properties, byte by byte.

use super::error::{AlembicError, damaged};

/// Number of an entry's metadata that stands beside it, not in the archive's table.
const OWN_METADATA: usize = 0xff;

/// What is left to read of a list.
pub(super) struct Cursor<'a>(pub(super) &'a [u8]);

impl<'a> Cursor<'a> {
    /// Tells whether all is read.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Takes some bytes.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where there are fewer.
    pub(super) fn take(&mut self, len: usize) -> Result<&'a [u8], AlembicError> {
        let (taken, left) =
            self.0.split_at_checked(len).ok_or_else(|| damaged("a list of names is cut off"))?;
        self.0 = left;
        Ok(taken)
    }

    /// Takes a number of 1, 2 or 4 bytes.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where there are fewer.
    pub(super) fn number(&mut self, bytes: usize) -> Result<usize, AlembicError> {
        let mut number = [0; 4];
        number[..bytes].copy_from_slice(self.take(bytes)?);
        Ok(u32::from_le_bytes(number) as usize)
    }

    /// Takes a text of as many bytes as a number before it says, which itself has `bytes`.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where there are fewer.
    pub(super) fn text(&mut self, bytes: usize) -> Result<String, AlembicError> {
        let len = self.number(bytes)?;
        Ok(String::from_utf8_lossy(self.take(len)?).into_owned())
    }
}

/// The texts that objects and properties say of themselves, of which the archive keeps those that are frequent.
pub(super) struct Metadata(Vec<String>);

impl Metadata {
    /// Reads the archive's table.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`]
    pub(super) fn read(bytes: &[u8]) -> Result<Self, AlembicError> {
        let mut cursor = Cursor(bytes);
        // The first says nothing.
        let mut table = vec![String::new()];
        while !cursor.is_empty() {
            table.push(cursor.text(1)?);
        }
        Ok(Self(table))
    }

    /// Gives the text of a number; a text of its own follows in the list, its length in `bytes`.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] for a number that the table does not have.
    pub(super) fn of(
        &self,
        number: usize,
        cursor: &mut Cursor<'_>,
        bytes: usize,
    ) -> Result<String, AlembicError> {
        if number == OWN_METADATA {
            return cursor.text(bytes);
        }
        let text = self.0.get(number).cloned();
        text.ok_or_else(|| damaged(format!("it names text {number} of {}", self.0.len())))
    }
}
