//! The container: parts in a file, sealed with its checksum.

use super::error::BakeError;
use super::sections::{Sections, narrow};
use sinew_runtime::Model;
use sinew_runtime::format::{
    ALIGNMENT, CHECKSUM_OFFSET, Element, FEATURES, File, MAGIC, PartKind, PartRow, SectionKind,
    SectionRow, Space, VERSION, checksum,
};

/// A part of a file, written.
pub struct Part {
    /// Its kind.
    pub kind: PartKind,
    /// Its sections, in the order of its kind.
    pub sections: Sections,
    /// What those are arrays of whose kind leaves a choice.
    pub element: Element,
}

/// Writes a file of parts and loads it once, so that what is returned is known to load.
///
/// # Errors
/// - [`BakeError::Size`]: an index or a size does not fit the file.
/// - [`BakeError::Refused`]: anything else that the runtime would refuse, as a number that is not
///   finite.
pub fn bake(space: Space, parts: &[Part]) -> Result<Vec<u8>, BakeError> {
    let bytes = assemble(space, parts)?;
    Model::from_bytes(&bytes).map_err(BakeError::Refused)?;
    Ok(bytes)
}

/// Lays sections out in a blob, writes the message, and seals it with its checksum.
fn assemble(space: Space, parts: &[Part]) -> Result<Vec<u8>, BakeError> {
    let (mut part_rows, mut rows, mut blob) = (Vec::new(), Vec::new(), Vec::new());
    for (part, Part { kind, sections, element }) in parts.iter().enumerate() {
        part_rows.extend(PartRow::new(*kind).to_bytes());
        for (kind, required, content) in sections {
            blob.resize(blob.len().next_multiple_of(ALIGNMENT), 0);
            let row = SectionRow {
                kind: kind.number(),
                part: narrow("parts", part)?,
                element: chosen(*kind, *element).number(),
                flags: u8::from(*required),
                reserved: 0,
                offset: narrow("blob bytes", blob.len())?,
                bytes: narrow("section bytes", content.len())?,
            };
            rows.extend(row.to_bytes());
            blob.extend(content);
        }
    }
    let mut file = File {
        magic: MAGIC,
        version: VERSION,
        features: FEATURES.to_le_bytes(),
        checksum: [0; 4],
        space: space.to_bytes(),
        parts: &part_rows,
        sections: &rows,
        padding: &[],
        blob: &[],
    };
    let zeros = [0; ALIGNMENT];
    let blob_len = serialize(&blob.len()).len();
    let padding = (0..zeros.len()).map(|len| &zeros[..len]).find(|&padding| {
        // One byte of the head is the length of its empty blob.
        (serialize(&File { padding, ..file }).len() - 1 + blob_len).is_multiple_of(ALIGNMENT)
    });
    file.padding = padding.unwrap_or_default();
    file.blob = &blob;
    let mut bytes = serialize(&file);
    let sum = checksum(&bytes).to_le_bytes();
    if let Some(field) = bytes.get_mut(CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4) {
        field.copy_from_slice(&sum);
    }
    Ok(bytes)
}

/// Returns the type of a section's elements: the part's, or the one that its kind has.
fn chosen(kind: SectionKind, of_part: Element) -> Element {
    let elements = kind.elements();
    if elements.contains(&of_part) { of_part } else { elements.first().copied().unwrap_or(of_part) }
}

fn serialize(value: &impl serde::Serialize) -> Vec<u8> {
    // A Vec takes any number of bytes, and every length here is known, so this cannot fail; if it
    // did, the runtime would refuse the empty file.
    postcard::to_extend(value, Vec::new()).unwrap_or_default()
}
