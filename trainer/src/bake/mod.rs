//! The container: the only writer of the file that [`sinew_runtime`] reads.
//!
//! The container knows each part as a kind and a list of sections. The parts decide what their sections hold.

pub(crate) mod sections;

pub use sections::Sections;

use crate::Error;
use sections::narrow;
use sinew_runtime::Model;
use sinew_runtime::format::{
    ALIGNMENT, CHECKSUM_OFFSET, Element, FEATURES, File, MAGIC, PartKind, PartRow, SectionKind,
    SectionRow, Space, VERSION, checksum,
};

/// A part of a file, ready to write.
pub struct Part {
    /// Kind of the part.
    pub kind: PartKind,
    /// Sections, in the order that the kind prescribes.
    pub sections: Sections,
    /// Element type of the sections whose kind allows several.
    pub element: Element,
}

/// Writes a file of parts, and loads it once to make sure that the runtime accepts it.
///
/// # Errors
/// - [`ErrorKind::Limit`](crate::ErrorKind::Limit): an index or a size does not fit the file.
/// - [`ErrorKind::Damaged`](crate::ErrorKind::Damaged): the runtime refuses the file, for example for a number that is
///   not finite.
pub fn bake(space: Space, parts: &[Part]) -> Result<Vec<u8>, Error> {
    let bytes = assemble(space, parts)?;
    Model::from_bytes(&bytes)
        .map_err(|error| Error::from(error).within("the runtime refuses the baked model"))?;
    Ok(bytes)
}

/// Lays out the sections in a blob, writes the message, and seals it with its checksum.
fn assemble(space: Space, parts: &[Part]) -> Result<Vec<u8>, Error> {
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
        // The head holds one byte for the length of its empty blob.
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

/// Returns the element type of a section: the part's, or the only type that the section's kind allows.
fn chosen(kind: SectionKind, of_part: Element) -> Element {
    let elements = kind.elements();
    if elements.contains(&of_part) { of_part } else { elements.first().copied().unwrap_or(of_part) }
}

fn serialize(value: &impl serde::Serialize) -> Vec<u8> {
    // Cannot fail: a Vec takes any number of bytes, and every length is known. If it did fail, the runtime would refuse
    // the empty file.
    postcard::to_extend(value, Vec::new()).unwrap_or_default()
}
