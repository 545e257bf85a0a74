//! A file as one postcard message: the head with the checksum, and four byte strings.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// Byte positions in the head of a file.
pub mod head {
    use std::ops::Range;

    /// Magic: the first bytes of every file.
    pub const MAGIC: Range<usize> = 0..4;
    /// Version byte.
    pub const VERSION: usize = 4;
    /// Bits of the required features.
    pub const FEATURES: Range<usize> = 5..9;
    /// Checksum of the whole file.
    pub const CHECKSUM: Range<usize> = 9..13;
    /// Axes and unit.
    pub const SPACE: Range<usize> = 13..21;
    /// Length of the head in bytes.
    pub const BYTES: usize = 21;

    /// Head of version 11: no features, checksum not yet computed, axes and unit unknown,
    /// right-handed.
    pub const SOUND: [u8; BYTES] = *b"SNEW\x0b\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0\0";
}

/// Alignment of sections and of the blob, in bytes.
pub(crate) const ALIGNMENT: usize = 16;

/// Content of a file, in order.
pub struct Message {
    /// Magic, version, features, checksum, space: see [`head`].
    pub head: [u8; head::BYTES],
    /// Rows of the part table.
    pub parts: Vec<u8>,
    /// Rows of the section table.
    pub sections: Vec<u8>,
    /// Zeros that bring the blob to a multiple of 16.
    pub padding: Vec<u8>,
    /// Bytes of all sections.
    pub blob: Vec<u8>,
}

impl Message {
    /// Makes a message with an aligned blob.
    pub(crate) fn new(
        head: [u8; head::BYTES],
        parts: Vec<u8>,
        sections: Vec<u8>,
        blob: Vec<u8>,
    ) -> Self {
        let string = |bytes: &[u8]| varint(bytes.len()).len() + bytes.len();
        // The length of the padding takes one byte.
        let before = head.len() + string(&parts) + string(&sections) + 1 + varint(blob.len()).len();
        let padding = vec![0; before.next_multiple_of(ALIGNMENT) - before];
        Self { head, parts, sections, padding, blob }
    }

    /// Writes the file with its checksum.
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = self.head.to_vec();
        for string in [&self.parts, &self.sections, &self.padding, &self.blob] {
            out.extend(varint(string.len()));
            out.extend(string);
        }
        seal(&mut out);
        out
    }
}

/// Repairs the checksum of a file, if it is long enough to have one.
pub fn seal(file: &mut [u8]) {
    static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
    if let Some(field) = file.get_mut(head::CHECKSUM) {
        field.fill(0);
        let sum = CRC.checksum(file).to_le_bytes();
        file[head::CHECKSUM].copy_from_slice(&sum);
    }
}

/// Encodes a length as a varint: seven bits per byte, least significant first.
fn varint(mut value: usize) -> Vec<u8> {
    let mut out = Vec::new();
    while value > 127 {
        out.push(value as u8 | 128);
        value >>= 7;
    }
    out.push(value as u8);
    out
}
