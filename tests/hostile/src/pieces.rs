//! A file taken apart, each piece free to be wrong, and put together again.
//!
//! Written by hand after FORMAT.md, so that it shares no mistake with the trainer's `bake`.

use sinew_runtime::format::{CHECKSUM_OFFSET, PartRow, SectionKind, SectionRow, checksum};
use sinew_runtime::{FormatError, Model};

/// The pieces of a file.
#[derive(Clone)]
pub struct Pieces {
    /// Magic, version, alignment, features, checksum.
    pub head: [u8; 14],
    /// Rows of the part table.
    pub parts: Vec<PartRow>,
    /// Rows of the section table with their content; offset and length are written anew.
    pub sections: Vec<(SectionRow, Vec<u8>)>,
}

impl Pieces {
    /// Takes a sound file apart.
    ///
    /// # Errors
    /// Why the file is not sound.
    pub fn of(file: &[u8]) -> Result<Self, FormatError> {
        let model = Model::from_bytes(file)?;
        let sections = model.sections().map(|section| (section.row, section.bytes.to_vec()));
        Ok(Self {
            head: *file.first_chunk().ok_or(FormatError::Malformed)?,
            parts: model.parts().collect(),
            sections: sections.collect(),
        })
    }

    /// Gives the content of the first section of a kind.
    pub fn section(&mut self, kind: SectionKind) -> Option<&mut Vec<u8>> {
        let found = self.sections.iter_mut().find(|(row, _)| row.kind == kind.number());
        found.map(|(_, bytes)| bytes)
    }

    /// Writes the file with its checksum; `edit` changes the section table after it is laid out.
    pub fn file(&self, edit: impl FnOnce(&mut [SectionRow])) -> Vec<u8> {
        // A wild alignment moves nothing: what it says is refused.
        let align = 1usize << self.head[5].clamp(4, 12);
        let (mut rows, mut blob) = (Vec::new(), Vec::new());
        for (row, bytes) in &self.sections {
            blob.resize(blob.len().next_multiple_of(align), 0);
            rows.push(SectionRow { offset: blob.len() as u32, bytes: bytes.len() as u32, ..*row });
            blob.extend(bytes);
        }
        edit(&mut rows);
        let mut out = self.head.to_vec();
        put(&mut out, &self.parts.iter().flat_map(PartRow::to_bytes).collect::<Vec<_>>());
        put(&mut out, &rows.iter().flat_map(SectionRow::to_bytes).collect::<Vec<_>>());
        let blob_len = varint(blob.len());
        let before = out.len() + blob_len.len();
        let fits = |len: &usize| (before + varint(*len).len() + len).is_multiple_of(align);
        // Of three lengths a block apart, one fits: the length's own bytes grow once at most.
        let padding = (0..3 * align).find(fits).unwrap_or_default();
        put(&mut out, &vec![0; padding]);
        out.extend(blob_len);
        out.extend(blob);
        seal(&mut out);
        out
    }
}

/// Repairs the checksum of a file.
pub fn seal(file: &mut [u8]) {
    let sum = checksum(file).to_le_bytes();
    if let Some(field) = file.get_mut(CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4) {
        field.copy_from_slice(&sum);
    }
}

fn put(out: &mut Vec<u8>, bytes: &[u8]) {
    out.extend(varint(bytes.len()));
    out.extend(bytes);
}

fn varint(mut value: usize) -> Vec<u8> {
    let mut out = Vec::new();
    while value > 127 {
        out.push(value as u8 | 128);
        value >>= 7;
    }
    out.push(value as u8);
    out
}
