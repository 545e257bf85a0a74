//! The only writer of the file that [`sinew_runtime`] reads.

mod envelope;
mod groups;
mod skin;

pub use envelope::{EnvelopeParts, Key, Reconstruction};
pub use groups::Group;
pub use skin::SkinParts;

use sinew_runtime::format::{
    ALIGNMENT, CHECKSUM_OFFSET, FEATURES, File, MAGIC, PartKind, PartRow, SectionKind, SectionRow,
    Space, VERSION, checksum,
};
use sinew_runtime::{FileError, Model};

/// Everything that a file holds, in f64 and in the examples' order.
#[derive(Clone, Debug, Default)]
pub struct ModelParts {
    /// The space of all its numbers.
    pub space: Space,
    /// What predicts palettes.
    pub envelopes: Vec<EnvelopeParts>,
    /// The meshes that follow them.
    pub skins: Vec<SkinParts>,
}

/// Why a model could not be baked.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum BakeError {
    /// An array does not fit the others.
    #[error("{what}: expected {expected} elements, found {found}")]
    Length {
        /// The array.
        what: &'static str,
        /// What the other arrays imply.
        expected: usize,
        /// What it has.
        found: usize,
    },
    /// A number is too large for its place in the file.
    #[error("{what}: {found} does not fit the file")]
    Size {
        /// What is counted or indexed.
        what: &'static str,
        /// The number.
        found: usize,
    },
    /// A joint cannot be reached from the root by way of parents.
    #[error("joint {joint} does not descend from the root")]
    Hierarchy {
        /// The joint.
        joint: usize,
    },
    /// A rest frame has no inverse.
    #[error("the rest frame of joint {joint} cannot be inverted")]
    RestFrame {
        /// The joint.
        joint: usize,
    },
    /// The weights of a vertex do not have a positive sum.
    #[error("the weights of vertex {vertex} sum to {sum}, expected 1")]
    Weights {
        /// The vertex.
        vertex: usize,
        /// Their sum.
        sum: f64,
    },
    /// A skin names an envelope that is not there.
    #[error("skin {skin} follows envelope {envelope}, of {found}")]
    NoEnvelope {
        /// The skin's number.
        skin: usize,
        /// The envelope's that it names.
        envelope: usize,
        /// How many there are.
        found: usize,
    },
    /// The runtime refuses what was written.
    #[error("the runtime refuses the baked model: {0}")]
    Refused(FileError),
}

/// Bakes a model into a file and loads it once, so that what is returned is known to load.
///
/// Weights are divided by their sum, then rounded; all else is rounded as it is.
///
/// # Errors
/// - [`BakeError::Length`]: arrays do not fit each other.
/// - [`BakeError::Size`]: an index or a size does not fit the file.
/// - [`BakeError::Hierarchy`]: joints do not form one tree.
/// - [`BakeError::RestFrame`]: a rest frame is singular.
/// - [`BakeError::Weights`]: a vertex has no positive sum of weights.
/// - [`BakeError::NoEnvelope`]: a skin follows an envelope that is not there.
/// - [`BakeError::Refused`]: anything else that the runtime would refuse, as a number that is not
///   finite.
pub fn bake(parts: &ModelParts) -> Result<Vec<u8>, BakeError> {
    let mut written = Vec::new();
    for envelope in &parts.envelopes {
        written.push((PartKind::Envelope, envelope.sections()?));
    }
    for (number, skin) in parts.skins.iter().enumerate() {
        let envelope = match skin.envelope {
            None => None,
            Some(envelope) => Some(parts.envelopes.get(envelope).ok_or(BakeError::NoEnvelope {
                skin: number,
                envelope,
                found: parts.envelopes.len(),
            })?),
        };
        written.push((PartKind::Skin, skin.sections(envelope)?));
    }
    let bytes = assemble(parts.space, &written)?;
    Model::from_bytes(&bytes).map_err(BakeError::Refused)?;
    Ok(bytes)
}

/// The sections of a part: kind, whether a reader must know it, and content.
type Sections = Vec<(SectionKind, bool, Vec<u8>)>;

/// Lays sections out in a blob, writes the message, and seals it with its checksum.
fn assemble(space: Space, parts: &[(PartKind, Sections)]) -> Result<Vec<u8>, BakeError> {
    let (mut part_rows, mut rows, mut blob) = (Vec::new(), Vec::new(), Vec::new());
    for (part, (kind, sections)) in parts.iter().enumerate() {
        part_rows.extend(PartRow::new(*kind).to_bytes());
        for (kind, required, content) in sections {
            blob.resize(blob.len().next_multiple_of(ALIGNMENT), 0);
            let row = SectionRow {
                kind: kind.number(),
                part: narrow("parts", part)?,
                element: kind.element().number(),
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

fn serialize(value: &impl serde::Serialize) -> Vec<u8> {
    // A Vec takes any number of bytes, and every length here is known, so this cannot fail; if it
    // did, the runtime would refuse the empty file.
    postcard::to_extend(value, Vec::new()).unwrap_or_default()
}

/// Writes the end of each name, then the names.
fn names<'a>(all: impl Iterator<Item = &'a String>) -> Result<Vec<u8>, BakeError> {
    let (mut ends, mut text) = (Vec::new(), Vec::<u8>::new());
    for name in all {
        text.extend(name.as_bytes());
        ends.extend(narrow::<u32>("name bytes", text.len())?.to_le_bytes());
    }
    ends.extend(text);
    Ok(ends)
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Cuts a row-major matrix into blocks of 8 rows, column-major, the last padded with zeros.
fn blocks(matrix: &[f64], column_len: usize) -> Vec<u8> {
    let mut out = Vec::new();
    for block in matrix.chunks(8 * column_len.max(1)) {
        for column in 0..column_len {
            let rows = (0..8).map(|row| block.get(row * column_len + column).copied());
            out.extend(floats(&rows.map(Option::unwrap_or_default).collect::<Vec<_>>()));
        }
    }
    out
}

fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect()
}

fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), BakeError> {
    if found == expected { Ok(()) } else { Err(BakeError::Length { what, expected, found }) }
}

fn narrow<T: TryFrom<usize>>(what: &'static str, found: usize) -> Result<T, BakeError> {
    T::try_from(found).map_err(|_| BakeError::Size { what, found })
}
