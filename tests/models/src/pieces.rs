//! Files in pieces that may be invalid, and their assembly.

use crate::bytes::{eights, from_eights, part_row, section_row};
use crate::message::head;
use crate::message::{ALIGNMENT, Message};
use sinew_runtime::format::{Element, MAGNITUDE_MAX, PartRow, SectionKind, SectionRow};
use sinew_runtime::skin::NO_ENVELOPE;
use sinew_runtime::{FileError, Model};

/// The pieces of a file. [`Pieces::sample`] and similar functions make samples.
#[derive(Clone)]
pub struct Pieces {
    /// Magic, version, features, checksum, space: see [`head`]. Writing recomputes the checksum.
    pub head: [u8; head::BYTES],
    /// Rows of the part table.
    pub parts: Vec<PartRow>,
    /// Sections, in the order of their rows.
    pub sections: Vec<Content>,
}

/// A section: its row and its bytes. Writing recomputes the row's offset and length.
#[derive(Clone)]
pub struct Content {
    /// Number of a [`SectionKind`].
    pub kind: u16,
    /// Index of its part.
    pub part: u16,
    /// Number of an [`Element`].
    pub element: u8,
    /// Bit 0: readers must know the kind.
    pub flags: u8,
    /// Zero.
    pub reserved: u16,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Content {
    /// Makes a section that readers must know.
    pub fn new(kind: SectionKind, part: u16, bytes: Vec<u8>) -> Self {
        let element = kind.elements()[0].number();
        Self { kind: kind.number(), part, element, flags: 1, reserved: 0, bytes }
    }

    /// Makes a section of a kind that no reader knows.
    pub fn unknown(kind: u16, part: u16, flags: u8) -> Self {
        let element = Element::Mixed.number();
        Self { kind, part, element, flags, reserved: 0, bytes: vec![1; 5] }
    }
}

impl Pieces {
    /// Splits a valid file into pieces.
    ///
    /// # Errors
    /// The reason why the file is invalid.
    pub fn of(file: &[u8]) -> Result<Self, FileError> {
        let model = Model::from_bytes(file)?;
        let sections = model.sections().map(|section| {
            let SectionRow { kind, part, element, flags, reserved, .. } = section.row;
            Content { kind, part, element, flags, reserved, bytes: section.bytes.to_vec() }
        });
        let mut head = [0; head::BYTES];
        head.iter_mut().zip(file).for_each(|(own, byte)| *own = *byte);
        Ok(Self { head, parts: model.parts().collect(), sections: sections.collect() })
    }

    /// Returns the content of the first section of a kind, if there is one. For names: of the first
    /// part.
    pub fn find(&mut self, kind: SectionKind) -> Option<&mut Vec<u8>> {
        let found = self.sections.iter_mut().find(|content| content.kind == kind.number());
        found.map(|content| &mut content.bytes)
    }

    /// Returns the content of the first section of a kind, to be changed.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn section(&mut self, kind: SectionKind) -> &mut Vec<u8> {
        self.find(kind).expect("the section exists")
    }

    /// Returns the content of a part's section, to be changed.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn section_of(&mut self, part: u16, kind: SectionKind) -> &mut Vec<u8> {
        let is_it = |content: &&mut Content| (content.part, content.kind) == (part, kind.number());
        let found = self.sections.iter_mut().find(is_it);
        &mut found.expect("the part has the section").bytes
    }

    /// Changes an attribute of the first skin, vertex by vertex; see [`eights`]. Vertices that are
    /// left out or added change the number of blocks.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn edit_vertices(&mut self, kind: SectionKind, edit: impl FnOnce(&mut Vec<u8>)) {
        let (len, size) = self.numbers(kind);
        let vertex_len = self.skin_count(0);
        let content = self.section(kind);
        let mut numbers = from_eights(content, len, size);
        numbers.truncate(vertex_len * len * size);
        edit(&mut numbers);
        *content = eights(&numbers, len, size);
    }

    /// Replaces an attribute of the first skin.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn set_vertices(&mut self, kind: SectionKind, numbers: &[u8]) {
        self.edit_vertices(kind, |own| *own = numbers.to_vec());
    }

    /// Returns the numbers of a vertex in an attribute of the first skin, and the bytes of a number.
    fn numbers(&mut self, kind: SectionKind) -> (usize, usize) {
        let influence_len = self.skin_count(1);
        match kind {
            SectionKind::RestTangents => (4, 4),
            SectionKind::InfluenceIndices => (influence_len, 2),
            SectionKind::InfluenceWeights => (influence_len, 4),
            SectionKind::TangentCoefficients => (influence_len - 1, 4),
            _ => (3, 4),
        }
    }

    /// Returns a count of the first skin.
    fn skin_count(&mut self, at: usize) -> usize {
        self.word(SectionKind::SkinCounts, at).map_or(0, |word| u32::from_le_bytes(*word) as usize)
    }

    /// Returns a word of the first section of a kind, if there is one.
    pub fn word(&mut self, kind: SectionKind, index: usize) -> Option<&mut [u8; 4]> {
        self.find(kind)?.as_chunks_mut().0.get_mut(index)
    }

    /// Replaces a word of the first section of a kind, for example a count.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn set_word(&mut self, kind: SectionKind, index: usize, value: u32) {
        *self.word(kind, index).expect("the word exists") = value.to_le_bytes();
    }

    /// Replaces a float of the first section of a kind.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn set_float(&mut self, kind: SectionKind, index: usize, value: f32) {
        self.set_word(kind, index, value.to_bits());
    }

    /// Replaces a u16 of the first section of a kind.
    ///
    /// # Panics
    /// If there is no section of this kind.
    pub fn set_half(&mut self, kind: SectionKind, index: usize, value: u16) {
        self.section(kind)[2 * index..][..2].copy_from_slice(&value.to_le_bytes());
    }

    /// Appends the parts of another file. References of its skins, priors and views to parts are
    /// renumbered.
    pub fn append(&mut self, other: Self) {
        let first = self.parts.len() as u16;
        self.parts.extend(other.parts);
        for mut content in other.sections {
            content.part += first;
            if content.kind == SectionKind::SkinCounts.number()
                && let Some(envelope) = content.bytes.as_chunks_mut().0.get_mut(2)
                && u32::from_le_bytes(*envelope) != NO_ENVELOPE
            {
                *envelope = (u32::from_le_bytes(*envelope) + u32::from(first)).to_le_bytes();
            }
            if content.kind == SectionKind::PriorCounts.number()
                && let Some(skin) = content.bytes.as_chunks_mut().0.first_mut()
            {
                *skin = (u32::from_le_bytes(*skin) + u32::from(first)).to_le_bytes();
            }
            if content.kind == SectionKind::Maps.number() {
                for map in content.bytes.as_chunks_mut().0 {
                    *map = (u32::from_le_bytes(*map) + u32::from(first)).to_le_bytes();
                }
            }
            self.sections.push(content);
        }
    }

    /// Drops the envelope of a file that has one envelope, and every reference to it.
    pub fn loosen(&mut self) {
        for (index, value) in [(1, 0), (2, NO_ENVELOPE)] {
            if let Some(word) = self.word(SectionKind::SkinCounts, index) {
                *word = value.to_le_bytes();
            }
        }
        self.parts.remove(0);
        let dropped = [
            SectionKind::InfluenceIndices,
            SectionKind::InfluenceWeights,
            SectionKind::RestBoxes,
            SectionKind::TangentCoefficients,
        ];
        let stays = |content: &Content| dropped.iter().all(|kind| kind.number() != content.kind);
        self.sections.retain(|content| content.part == 1 && stays(content));
        self.sections.iter_mut().for_each(|content| content.part = 0);
    }

    /// Keeps only the first vertices of the first skin, in every section; without vertices the rest
    /// boxes are empty.
    pub fn keep_vertices(&mut self, vertex_len: u32) {
        let Some(influence_len) = self.word(SectionKind::SkinCounts, 1) else { return };
        let influence_len = u32::from_le_bytes(*influence_len) as usize;
        self.set_word(SectionKind::SkinCounts, 0, vertex_len);
        let block_len = vertex_len.div_ceil(8) as usize;
        for (kind, bytes) in [
            (SectionKind::RestPositions, 12),
            (SectionKind::RestNormals, 12),
            (SectionKind::RestTangents, 16),
            (SectionKind::InfluenceIndices, influence_len.saturating_mul(2)),
            (SectionKind::InfluenceWeights, influence_len.saturating_mul(4)),
            (SectionKind::TangentCoefficients, influence_len.saturating_sub(1).saturating_mul(4)),
        ] {
            if let Some(content) = self.find(kind) {
                content.truncate(block_len.saturating_mul(8).saturating_mul(bytes));
            }
        }
        if let Some(ranges) = self.find(SectionKind::Ranges) {
            for word in ranges.as_chunks_mut::<4>().0 {
                *word = u32::from_le_bytes(*word).min(vertex_len).to_le_bytes();
            }
        }
        if vertex_len == 0
            && let Some(boxes) = self.find(SectionKind::RestBoxes)
        {
            // The minimum of x is above its maximum: an empty box.
            let (words, _) = boxes.as_chunks_mut::<4>();
            words.chunks_mut(6).for_each(|rest_box| rest_box[0] = MAGNITUDE_MAX.to_le_bytes());
        }
    }

    /// Writes the file with its checksum.
    pub fn bytes(&self) -> Vec<u8> {
        self.message(|_| {}).bytes()
    }

    /// Writes the file with its checksum; `edit` changes the section table after the layout.
    pub fn bytes_with_rows(&self, edit: impl FnOnce(&mut [SectionRow])) -> Vec<u8> {
        self.message(edit).bytes()
    }

    /// Writes the file with its checksum; `edit` changes the message after the layout.
    pub fn bytes_with(&self, edit: impl FnOnce(&mut Message)) -> Vec<u8> {
        let mut message = self.message(|_| {});
        edit(&mut message);
        message.bytes()
    }

    /// Lays out the sections, each at its alignment.
    fn message(&self, edit: impl FnOnce(&mut [SectionRow])) -> Message {
        let (mut rows, mut blob) = (Vec::new(), Vec::new());
        for &Content { kind, part, element, flags, reserved, ref bytes } in &self.sections {
            blob.resize(blob.len().next_multiple_of(ALIGNMENT), 0);
            let (offset, len) = (blob.len() as u32, bytes.len() as u32);
            rows.push(SectionRow { kind, part, element, flags, reserved, offset, bytes: len });
            blob.extend(bytes);
        }
        edit(&mut rows);
        let parts = self.parts.iter().flat_map(part_row).collect();
        Message::new(self.head, parts, rows.iter().flat_map(section_row).collect(), blob)
    }
}
