//! Ogawa, the container of Alembic: groups of groups and of data, by their places in the file.
//!
//! A header of 16 bytes names the root group. A group is a count and as many places, a data is a count of bytes and
//! the bytes; a place with its highest bit set is a data's. What is empty is at place 0. Numbers are little-endian,
//! but for the version (`lib/Alembic/Ogawa` of the Alembic library).
//! The lists of names that Alembic keeps behind its objects and properties, byte by byte.

use super::{AlembicError, damaged};
use std::cell::Cell;

const MAGIC: &[u8; 5] = b"Ogawa";
const HDF5: &[u8; 4] = b"\x89HDF";
const FROZEN: u8 = 0xff;
const VERSION: [u8; 2] = [0, 1];
const HEADER_BYTES: usize = 16;

/// The bit of a place that makes it a data's.
const DATA: u64 = 1 << 63;

/// Bytes that reading may unfold a file to: as many for each byte of it as long pauses and loops take, which are
/// stored once, up to a limit for all.
const UNFOLDED_A_BYTE: usize = 64;
const UNFOLDED_LEAST: usize = 64 << 20;
const UNFOLDED_MOST: usize = 4 << 30;

/// The bytes of a file.
pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    unfolded_most: usize,
    /// How much more may be unfolded.
    left: Cell<usize>,
}

/// A group, whose children are looked up where they are asked for.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    archive: &'a Archive<'a>,
    children: &'a [[u8; 8]],
}

impl<'a> Archive<'a> {
    /// Checks the header of a file.
    ///
    /// # Errors
    /// [`AlembicError::Hdf5`], [`AlembicError::NotAlembic`] and [`AlembicError::Unfinished`].
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, AlembicError> {
        if bytes.starts_with(HDF5) {
            return Err(AlembicError::Hdf5);
        }
        let not = |reason: &str| AlembicError::NotAlembic { reason: reason.to_owned() };
        if !bytes.starts_with(MAGIC) {
            return Err(not("it does not begin with Ogawa"));
        }
        let Some(&[_, _, _, _, _, frozen, major, minor, ..]) = bytes.first_chunk::<HEADER_BYTES>()
        else {
            return Err(damaged("it ends in its header"));
        };
        if frozen != FROZEN {
            return Err(AlembicError::Unfinished);
        }
        if [major, minor] != VERSION {
            let version = u16::from_be_bytes([major, minor]);
            return Err(not(&format!("it is of version {version}")));
        }
        let unfolded_most =
            bytes.len().saturating_mul(UNFOLDED_A_BYTE).clamp(UNFOLDED_LEAST, UNFOLDED_MOST);
        Ok(Self { bytes, unfolded_most, left: Cell::new(unfolded_most) })
    }

    /// Gives the root group.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where it is not in the file.
    pub(super) fn root(&'a self) -> Result<Group<'a>, AlembicError> {
        self.group(self.number(HEADER_BYTES as u64 - 8)?)
    }

    /// Takes bytes that are about to be read or made from what may still be, so that a file which names the same bytes
    /// again and again takes neither time nor memory without end.
    ///
    /// # Errors
    /// [`AlembicError::TooLarge`]
    pub(super) fn spend(&self, bytes: usize) -> Result<(), AlembicError> {
        let left = self.left.get().checked_sub(bytes);
        self.left.set(left.ok_or(AlembicError::TooLarge { most: self.unfolded_most })?);
        Ok(())
    }

    fn group(&'a self, place: u64) -> Result<Group<'a>, AlembicError> {
        let children = match place {
            0 => &[],
            _ => {
                let len = self.number(place)?.checked_mul(8);
                let bytes = len.and_then(|len| self.slice(place.checked_add(8)?, len));
                let bytes =
                    bytes.ok_or_else(|| damaged(format!("a group at {place} is cut off")))?;
                bytes.as_chunks().0
            }
        };
        Ok(Group { archive: self, children })
    }

    fn data(&'a self, place: u64) -> Result<&'a [u8], AlembicError> {
        if place == 0 {
            return Ok(&[]);
        }
        let len = self.number(place)?;
        let bytes = place.checked_add(8).and_then(|begin| self.slice(begin, len));
        bytes.ok_or_else(|| damaged(format!("data at {place} is cut off")))
    }

    fn number(&self, place: u64) -> Result<u64, AlembicError> {
        let bytes = self.slice(place, 8).and_then(|bytes| bytes.first_chunk());
        let bytes =
            bytes.ok_or_else(|| damaged(format!("it names byte {place}, behind its end")))?;
        Ok(u64::from_le_bytes(*bytes))
    }

    fn slice(&self, begin: u64, len: u64) -> Option<&[u8]> {
        let end = usize::try_from(begin.checked_add(len)?).ok()?;
        self.bytes.get(usize::try_from(begin).ok()?..end)
    }
}

impl<'a> Group<'a> {
    /// Gives the archive.
    pub(super) fn archive(&self) -> &'a Archive<'a> {
        self.archive
    }

    /// Counts the children.
    pub(super) fn len(&self) -> usize {
        self.children.len()
    }

    /// Gives the child `index`, a group.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where it is none.
    pub(super) fn group(&self, index: usize) -> Result<Group<'a>, AlembicError> {
        match self.place(index) {
            Some(place) if place & DATA == 0 => self.archive.group(place),
            _ => Err(damaged(format!("a group has no group as child {index}"))),
        }
    }

    /// Gives the bytes of the child `index`, a data.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] where it is none.
    pub(super) fn data(&self, index: usize) -> Result<&'a [u8], AlembicError> {
        match self.place(index) {
            Some(place) if place & DATA != 0 => self.archive.data(place & !DATA),
            _ => Err(damaged(format!("a group has no data as child {index}"))),
        }
    }

    /// Gives the bytes of the last child; none where it is a group, or there is none.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`]
    pub(super) fn last_data(&self) -> Result<&'a [u8], AlembicError> {
        match self.len().checked_sub(1) {
            Some(last) if self.place(last).is_some_and(|place| place & DATA != 0) => {
                self.data(last)
            }
            _ => Ok(&[]),
        }
    }

    fn place(&self, index: usize) -> Option<u64> {
        self.children.get(index).map(|bytes| u64::from_le_bytes(*bytes))
    }
}

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
