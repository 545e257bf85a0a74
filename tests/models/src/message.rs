//! A file as one postcard message: the head, four byte strings, the checksum.

use crate::head;
use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// Sections and the blob start at multiples of so many bytes.
pub(crate) const ALIGNMENT: usize = 16;

/// What stands in a file, one after the other.
pub struct Message {
    /// Magic, version, features, checksum, space: see [`head`].
    pub head: [u8; head::BYTES],
    /// Rows of the part table.
    pub parts: Vec<u8>,
    /// Rows of the section table.
    pub sections: Vec<u8>,
    /// Zeros that bring the blob to a multiple of 16.
    pub padding: Vec<u8>,
    /// Every section.
    pub blob: Vec<u8>,
}

impl Message {
    /// Makes a message whose blob is aligned.
    pub(crate) fn new(
        head: [u8; head::BYTES],
        parts: Vec<u8>,
        sections: Vec<u8>,
        blob: Vec<u8>,
    ) -> Self {
        let string = |bytes: &[u8]| varint(bytes.len()).len() + bytes.len();
        // One byte is the padding's own length.
        let before = head.len() + string(&parts) + string(&sections) + 1 + varint(blob.len()).len();
        let padding = vec![0; before.next_multiple_of(ALIGNMENT) - before];
        Self { head, parts, sections, padding, blob }
    }

    /// Writes the file and seals it.
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

/// Writes a length, seven bits a byte, the least significant first.
fn varint(mut value: usize) -> Vec<u8> {
    let mut out = Vec::new();
    while value > 127 {
        out.push(value as u8 | 128);
        value >>= 7;
    }
    out.push(value as u8);
    out
}
