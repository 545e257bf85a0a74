//! Bytes read one after another, big-endian.

use super::super::error::LayeredError;

/// The rest of some bytes, and where they begin in the file.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    left: &'a [u8],
    start: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes, start: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.left.len()
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        self.left
    }

    /// Returns where the next byte is in the file.
    pub(super) fn at(&self) -> usize {
        self.start
    }

    /// Takes the next `len` bytes.
    ///
    /// # Errors
    /// [`LayeredError::Damaged`]: fewer are left.
    pub(super) fn take(&mut self, len: usize) -> Result<Self, LayeredError> {
        let found = self.left.len();
        let Some((own, left)) = self.left.split_at_checked(len) else {
            let at = self.start;
            let what = format!("expected {len} bytes at byte {at}, found {found}");
            return Err(LayeredError::Damaged(what));
        };
        let taken = Self { left: own, start: self.start };
        (self.left, self.start) = (left, self.start + len);
        Ok(taken)
    }

    /// Takes bytes whose number stands before them.
    pub(super) fn block(&mut self) -> Result<Self, LayeredError> {
        let len = self.u32()? as usize;
        self.take(len)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], LayeredError> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?.left);
        Ok(out)
    }

    pub(super) fn u8(&mut self) -> Result<u8, LayeredError> {
        Ok(u8::from_be_bytes(self.array()?))
    }

    pub(super) fn u16(&mut self) -> Result<u16, LayeredError> {
        Ok(u16::from_be_bytes(self.array()?))
    }

    pub(super) fn i16(&mut self) -> Result<i16, LayeredError> {
        Ok(i16::from_be_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, LayeredError> {
        Ok(u32::from_be_bytes(self.array()?))
    }

    pub(super) fn i32(&mut self) -> Result<i32, LayeredError> {
        Ok(i32::from_be_bytes(self.array()?))
    }
}

/// Finds a block by its key among blocks that are padded to a multiple of `padding` bytes.
pub(super) fn blocks<'a>(
    mut left: Bytes<'a>,
    key: &[u8; 4],
    padding: usize,
) -> Result<Option<Bytes<'a>>, LayeredError> {
    while left.len() >= 12 {
        let signature: [u8; 4] = left.array()?;
        if !matches!(&signature, b"8BIM" | b"8B64") {
            break;
        }
        let found: [u8; 4] = left.array()?;
        let block = left.block()?;
        if found == *key {
            return Ok(Some(block));
        }
        let rest = block.len().next_multiple_of(padding) - block.len();
        left.take(rest.min(left.len()))?;
    }
    Ok(None)
}
