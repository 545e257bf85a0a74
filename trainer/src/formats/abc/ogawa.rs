//! Ogawa, the container of Alembic, and its lists of names.
//!
//! A header of 16 bytes gives the place of the root group. A group is a count and the places of its children. A data
//! node is a count of bytes and the bytes. A place whose highest bit is set refers to a data node; place 0 refers to an
//! empty node. Numbers are little-endian, except the version (`lib/Alembic/Ogawa` of the Alembic library).

use crate::Error;
use std::cell::Cell;
use std::fmt::Display;

const MAGIC: &[u8; 5] = b"Ogawa";
const HDF5: &[u8; 4] = b"\x89HDF";
const FROZEN: u8 = 0xff;
const VERSION: [u8; 2] = [0, 1];
const HEADER_BYTES: usize = 16;

/// Bit of a place that marks a data node.
const DATA: u64 = 1 << 63;

/// Memory budget of a reader, in bytes for each byte of the file, with a lower and an upper limit. The file stores
/// repeated samples once; the factor leaves room for long pauses and loops.
const UNFOLDED_A_BYTE: usize = 64;
const UNFOLDED_LEAST: usize = 64 << 20;
const UNFOLDED_MOST: usize = 4 << 30;

/// Metadata index of an entry that carries its metadata, instead of using the archive's table.
const OWN_METADATA: usize = 0xff;

/// The bytes of a file, with the budget for reading them.
pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    unfolded_most: usize,
    /// Bytes of the budget that remain.
    left: Cell<usize>,
}

/// A group. Its children are resolved on access.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub(super) archive: &'a Archive<'a>,
    children: &'a [[u8; 8]],
}

impl<'a> Archive<'a> {
    /// Checks the header of a file.
    ///
    /// # Errors
    /// The file uses the HDF5 container, does not begin as a supported archive, or is not finished.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Error> {
        if bytes.starts_with(HDF5) {
            return Err(Error::unsupported(
                "is Alembic in an HDF5 container, which is not read; export it again with Ogawa as \
                 its data format",
            ));
        }
        if !bytes.starts_with(MAGIC) {
            return Err(not_alembic("it does not begin with Ogawa"));
        }
        let Some(&[_, _, _, _, _, frozen, major, minor, ..]) = bytes.first_chunk::<HEADER_BYTES>()
        else {
            return Err(damaged("it ends in its header"));
        };
        if frozen != FROZEN {
            return Err(Error::damaged(
                "is incomplete: the program that wrote it did not finish; export it again",
            ));
        }
        if [major, minor] != VERSION {
            let version = u16::from_be_bytes([major, minor]);
            return Err(not_alembic(format!("it is of version {version}")));
        }
        let unfolded_most =
            bytes.len().saturating_mul(UNFOLDED_A_BYTE).clamp(UNFOLDED_LEAST, UNFOLDED_MOST);
        Ok(Self { bytes, unfolded_most, left: Cell::new(unfolded_most) })
    }

    /// Returns the root group.
    ///
    /// # Errors
    /// The root group is not in the file.
    pub(super) fn root(&'a self) -> Result<Group<'a>, Error> {
        self.group(self.number(HEADER_BYTES as u64 - 8)?)
    }

    /// Subtracts bytes from the memory budget before they are read or allocated.
    ///
    /// The budget bounds time and memory for a file that refers to the same bytes again and again.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit): the budget is spent.
    pub(super) fn spend(&self, bytes: usize) -> Result<(), Error> {
        let too_large = || {
            let most = self.unfolded_most;
            Error::limit(format!(
                "unfolds to more than {most} bytes, the most for a file of its size, by naming the \
                 same bytes again and again; export the frames that are wanted alone"
            ))
        };
        let left = self.left.get().checked_sub(bytes);
        self.left.set(left.ok_or_else(too_large)?);
        Ok(())
    }

    fn group(&'a self, place: u64) -> Result<Group<'a>, Error> {
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

    fn data(&'a self, place: u64) -> Result<&'a [u8], Error> {
        if place == 0 {
            return Ok(&[]);
        }
        let len = self.number(place)?;
        let bytes = place.checked_add(8).and_then(|begin| self.slice(begin, len));
        bytes.ok_or_else(|| damaged(format!("data at {place} is cut off")))
    }

    fn number(&self, place: u64) -> Result<u64, Error> {
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
    /// Counts the children.
    pub(super) fn len(&self) -> usize {
        self.children.len()
    }

    /// Returns child `index`, a group.
    ///
    /// # Errors
    /// The child is not a group, or is cut off.
    pub(super) fn group(&self, index: usize) -> Result<Group<'a>, Error> {
        match self.place(index) {
            Some(place) if place & DATA == 0 => self.archive.group(place),
            _ => Err(damaged(format!("a group has no group as child {index}"))),
        }
    }

    /// Returns the bytes of data child `index`.
    ///
    /// # Errors
    /// The child is not data, or is cut off.
    pub(super) fn data(&self, index: usize) -> Result<&'a [u8], Error> {
        match self.place(index) {
            Some(place) if place & DATA != 0 => self.archive.data(place & !DATA),
            _ => Err(damaged(format!("a group has no data as child {index}"))),
        }
    }

    /// Returns the bytes of the last child; empty if the child is a group or does not exist.
    ///
    /// # Errors
    /// The child is cut off.
    pub(super) fn last_data(&self) -> Result<&'a [u8], Error> {
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

/// The unread rest of a list.
pub(super) struct Cursor<'a>(pub(super) &'a [u8]);

impl<'a> Cursor<'a> {
    /// Reads `len` bytes.
    ///
    /// # Errors
    /// Fewer bytes are left.
    pub(super) fn take(&mut self, len: usize) -> Result<&'a [u8], Error> {
        let (taken, left) =
            self.0.split_at_checked(len).ok_or_else(|| damaged("a list of names is cut off"))?;
        self.0 = left;
        Ok(taken)
    }

    /// Reads a number of 1, 2 or 4 bytes.
    ///
    /// # Errors
    /// Fewer bytes are left.
    pub(super) fn number(&mut self, bytes: usize) -> Result<usize, Error> {
        let mut number = [0; 4];
        number[..bytes].copy_from_slice(self.take(bytes)?);
        Ok(u32::from_le_bytes(number) as usize)
    }

    /// Reads a text and, before it, its length, a number of `bytes` bytes.
    ///
    /// # Errors
    /// Fewer bytes are left.
    pub(super) fn text(&mut self, bytes: usize) -> Result<String, Error> {
        let len = self.number(bytes)?;
        Ok(String::from_utf8_lossy(self.take(len)?).into_owned())
    }
}

/// The archive's table of frequent metadata texts.
pub(super) struct Metadata(Vec<String>);

impl Metadata {
    /// Reads the archive's table.
    ///
    /// # Errors
    /// The table is cut off.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Error> {
        let mut cursor = Cursor(bytes);
        // Entry 0 is the empty text.
        let mut table = vec![String::new()];
        while !cursor.0.is_empty() {
            table.push(cursor.text(1)?);
        }
        Ok(Self(table))
    }

    /// Returns the metadata text of an index; a text outside the table follows in the list, its length in `bytes`
    /// bytes.
    ///
    /// # Errors
    /// The table does not have the index, or the list is cut off.
    pub(super) fn of(
        &self,
        number: usize,
        cursor: &mut Cursor<'_>,
        bytes: usize,
    ) -> Result<String, Error> {
        if number == OWN_METADATA {
            return cursor.text(bytes);
        }
        let text = self.0.get(number).cloned();
        text.ok_or_else(|| damaged(format!("it names text {number} of {}", self.0.len())))
    }
}

/// Makes the error of a file that does not begin as a supported archive.
pub(super) fn not_alembic(reason: impl Display) -> Error {
    Error::damaged(format!(
        "is no Alembic archive of Ogawa's version 1: {reason}; export it as .abc again"
    ))
}

/// Makes the error of a contradiction.
pub(super) fn damaged(what: impl Display) -> Error {
    Error::damaged(format!("is damaged: {what}; export it again"))
}
