//! A file taken apart, each piece free to be wrong, and put together again.
//!
//! Written by hand after FORMAT.md, so that it shares no mistake with the trainer's `bake`.

use crate::golden::GOLDEN;
use sinew_runtime::format::{
    ALIGNMENT, CHECKSUM_OFFSET, MAGNITUDE_MAX, PartRow, SectionKind, SectionRow, checksum,
};
use sinew_runtime::skin::NO_ENVELOPE;
use sinew_runtime::{FileError, Model};

/// The pieces of a file.
#[derive(Clone)]
pub struct Pieces {
    /// Magic, version, features, checksum, space.
    pub head: [u8; 21],
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
    pub fn of(file: &[u8]) -> Result<Self, FileError> {
        let model = Model::from_bytes(file)?;
        let sections = model.sections().map(|section| (section.row, section.bytes.to_vec()));
        let mut head = [0; 21];
        head.iter_mut().zip(file).for_each(|(own, byte)| *own = *byte);
        Ok(Self { head, parts: model.parts().collect(), sections: sections.collect() })
    }

    /// Gives the content of the first section of a kind.
    pub fn section(&mut self, kind: SectionKind) -> Option<&mut Vec<u8>> {
        let found = self.sections.iter_mut().find(|(row, _)| row.kind == kind.number());
        found.map(|(_, bytes)| bytes)
    }

    /// Reads a word of the first section of a kind, as a count.
    pub fn word(&self, kind: SectionKind, index: usize) -> Option<u32> {
        let (_, bytes) = self.sections.iter().find(|(row, _)| row.kind == kind.number())?;
        bytes.as_chunks().0.get(index).map(|le| u32::from_le_bytes(*le))
    }

    /// Replaces a word of the first section of a kind, where there is one.
    pub fn set_word(&mut self, kind: SectionKind, index: usize, value: u32) {
        let words = self.section(kind).map(|bytes| bytes.as_chunks_mut().0);
        if let Some(word) = words.and_then(|words| words.get_mut(index)) {
            *word = value.to_le_bytes();
        }
    }

    /// Appends the parts of another file; what its skins follow goes with them.
    pub fn append(&mut self, other: Self) {
        let first = self.parts.len() as u16;
        self.parts.extend(other.parts);
        for (mut row, mut bytes) in other.sections {
            row.part += first;
            if row.kind == SectionKind::SkinCounts.number()
                && let Some(envelope) = bytes.as_chunks_mut().0.get_mut(2)
                && u32::from_le_bytes(*envelope) != NO_ENVELOPE
            {
                *envelope = (u32::from_le_bytes(*envelope) + u32::from(first)).to_le_bytes();
            }
            self.sections.push((row, bytes));
        }
    }

    /// Drops the envelope of a file of one, and all that follows from it.
    pub fn loosen(&mut self) {
        self.set_word(SectionKind::SkinCounts, 1, 0);
        self.set_word(SectionKind::SkinCounts, 2, NO_ENVELOPE);
        self.parts.remove(0);
        let dropped =
            [SectionKind::InfluenceIndices, SectionKind::InfluenceWeights, SectionKind::RestBoxes];
        self.sections.retain(|(row, _)| {
            row.part == 1 && dropped.iter().all(|kind| kind.number() != row.kind)
        });
        self.sections.iter_mut().for_each(|(row, _)| row.part = 0);
    }

    /// Writes the file with its checksum; `edit` changes the section table after it is laid out.
    pub fn file(&self, edit: impl FnOnce(&mut [SectionRow])) -> Vec<u8> {
        let (mut rows, mut blob) = (Vec::new(), Vec::new());
        for (row, bytes) in &self.sections {
            blob.resize(blob.len().next_multiple_of(ALIGNMENT), 0);
            rows.push(SectionRow { offset: blob.len() as u32, bytes: bytes.len() as u32, ..*row });
            blob.extend(bytes);
        }
        edit(&mut rows);
        let mut out = self.head.to_vec();
        put(&mut out, &self.parts.iter().flat_map(PartRow::to_bytes).collect::<Vec<_>>());
        put(&mut out, &rows.iter().flat_map(SectionRow::to_bytes).collect::<Vec<_>>());
        let blob_len = varint(blob.len());
        // One byte is the padding's own length.
        let before = out.len() + blob_len.len() + 1;
        put(&mut out, &vec![0; before.next_multiple_of(ALIGNMENT) - before]);
        out.extend(blob_len);
        out.extend(blob);
        seal(&mut out);
        out
    }
}

/// Makes a file of two envelopes and three skins: those of a rotational and of a kernel model, and one
/// that follows nothing.
///
/// # Errors
/// Why a golden file is not sound.
pub(crate) fn several() -> Result<Vec<u8>, FileError> {
    let [rotational, kernel, hybrid] = GOLDEN.map(Pieces::of);
    let (mut out, mut loose) = (rotational?, hybrid?);
    out.append(kernel?);
    keep_vertices(&mut loose, 3);
    loose.loosen();
    out.append(loose);
    Ok(out.file(|_| {}))
}

/// Keeps the first skin's first vertices only, everywhere; of none there are no rest boxes.
pub(crate) fn keep_vertices(pieces: &mut Pieces, vertex_len: u32) {
    let Some(influence_len) = pieces.word(SectionKind::SkinCounts, 1) else { return };
    pieces.set_word(SectionKind::SkinCounts, 0, vertex_len);
    let influence_len = influence_len as usize;
    for (kind, bytes) in [
        (SectionKind::RestPositions, 12),
        (SectionKind::RestNormals, 12),
        (SectionKind::RestTangents, 16),
        (SectionKind::InfluenceIndices, influence_len.saturating_mul(2)),
        (SectionKind::InfluenceWeights, influence_len.saturating_mul(4)),
    ] {
        if let Some(content) = pieces.section(kind) {
            content.truncate((vertex_len as usize).saturating_mul(bytes));
        }
    }
    if let Some(ranges) = pieces.section(SectionKind::Ranges) {
        for word in ranges.as_chunks_mut::<4>().0 {
            *word = u32::from_le_bytes(*word).min(vertex_len).to_le_bytes();
        }
    }
    if vertex_len == 0
        && let Some(boxes) = pieces.section(SectionKind::RestBoxes)
    {
        // Least x is above greatest x: a box around nothing.
        let (words, _) = boxes.as_chunks_mut::<4>();
        words.chunks_mut(6).for_each(|rest_box| rest_box[0] = MAGNITUDE_MAX.to_le_bytes());
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
