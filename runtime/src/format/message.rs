//! The message: the file as a whole, and the limits of all its numbers.

use super::crc;
use serde::{Serialize, Serializer};

/// First bytes of every file.
pub const MAGIC: [u8; 4] = *b"SNEW";
/// Format version that this crate reads and that the trainer writes.
pub const VERSION: u8 = 11;
/// Feature bits that a reader must know; this version has none.
pub const FEATURES: u32 = 0;
/// Alignment of sections and the blob, in bytes.
pub const ALIGNMENT: usize = 16;
/// Byte offset of the checksum in the file.
pub const CHECKSUM_OFFSET: usize = 9;

/// Byte offset of the space in the file.
pub(crate) const SPACE_OFFSET: usize = CHECKSUM_OFFSET + 4;
/// Bytes before the first byte string.
pub(crate) const HEAD_BYTES: usize = SPACE_OFFSET + 8;

/// Largest magnitude of any float in a file.
///
/// The bound makes evaluation finite for every pose with rigid matrices and translations within
/// [`TRAVEL_MAX`], for any other content of the file. Sizes are at most 65,535. H's rows give at
/// most 2 * 1e9 * √3 π < 1.1e10, so a gradient's column stays below 2e10. In c1, 3 P columns sum to
/// less than 4e24. In c2, 4 J columns of q, each below 3.6e12, sum to less than 1e27. The root's
/// rotation leaves the sum below 2e27, and a correction ([`CORRECTION_MAX`]) below 4e28. A vertex
/// or a corner of a rest box at three times 1e9 stays below 2e38; `f32::MAX` is 3.4e38. Where a
/// normal's cofactors overflow, the rest normal is used instead.
pub const MAGNITUDE_MAX: f32 = 1.0e9;
/// Largest distance of a joint in a pose from its rest position, in units of the model. Up to this
/// distance every value stays finite.
pub const TRAVEL_MAX: f32 = 1.0e12;
/// Largest magnitude of any float of a correction, and of a fade's squared distances.
///
/// A kernel map is evaluated only if some centre is nearer than √1e6 = 1e3, so |x| < 1.1e6 there.
/// Sizes are below 65,536 and |G - rest| is below 1.1e6. A latent value therefore stays below 2 *
/// 65,536 * 1e6 * 1.1e6 < 1.5e17, and an output below 65,536 * 1e6 * 1.5e17 < 1e28. The rotation of
/// a rigid pose keeps the output below 3e28, far from `f32::MAX`.
pub const CORRECTION_MAX: f32 = 1.0e6;

/// The whole file as one postcard message, for a writer. The fields before the byte strings have
/// fixed offsets, which a reader uses.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct File<'a> {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`VERSION`].
    pub version: u8,
    /// Features that a reader must support, little-endian.
    pub features: [u8; 4],
    /// [`checksum`] of the file, little-endian.
    pub checksum: [u8; 4],
    /// A [`super::Space`].
    pub space: [u8; 8],
    /// Rows of [`super::PartRow::BYTES`].
    #[serde(serialize_with = "at_once")]
    pub parts: &'a [u8],
    /// Rows of [`super::SectionRow::BYTES`], in the order of their offsets.
    #[serde(serialize_with = "at_once")]
    pub sections: &'a [u8],
    /// Zeros that align the blob.
    #[serde(serialize_with = "at_once")]
    pub padding: &'a [u8],
    /// All sections.
    #[serde(serialize_with = "at_once")]
    pub blob: &'a [u8],
}

/// Writes bytes in one call, where postcard would write single bytes. Under Miri single bytes take
/// seconds.
fn at_once<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytes)
}

/// Computes the CRC-32 (ISO-HDLC) of a file, with the checksum field itself taken as zero.
pub fn checksum(file: &[u8]) -> u32 {
    let (head, rest) = file.split_at_checked(CHECKSUM_OFFSET).unwrap_or((file, &[]));
    let (zeros, rest) = rest.split_at_checked(4).map_or((0, rest), |(_, rest)| (4, rest));
    crc::of(&[head, [0; 4].get(..zeros).unwrap_or_default(), rest])
}
