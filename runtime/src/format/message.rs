//! The message: what a file is as a whole, and the numbers that hold for all of it.

use super::crc;
use serde::{Serialize, Serializer};

/// First bytes of every file.
pub const MAGIC: [u8; 4] = *b"SNEW";
/// The version that this crate reads and that the trainer writes.
pub const VERSION: u8 = 8;
/// Feature bits that a reader must know; this version has none.
pub const FEATURES: u32 = 0;
/// Sections and the blob start at multiples of so many bytes.
pub const ALIGNMENT: usize = 16;
/// Where the checksum stands in the file.
pub const CHECKSUM_OFFSET: usize = 9;

/// Where the space stands in the file.
pub(crate) const SPACE_OFFSET: usize = CHECKSUM_OFFSET + 4;
/// Bytes before the first byte string.
pub(crate) const HEAD_BYTES: usize = SPACE_OFFSET + 8;

/// Largest magnitude of any float in a file.
///
/// With it, every pose whose matrices are rigid and whose translations stay within [`TRAVEL_MAX`]
/// evaluates to finite values, whatever else a file says. Sizes are at most 65,535, and H's rows give
/// at most 2 * 1e9 * √3 π < 1.1e10, so a gradient's column stays below 2e10; 3 P of them in c1 sum
/// to less than 4e24, 4 J columns of q, below 3.6e12 each, in c2 to less than 1e27. The root's turn
/// leaves that below 2e27, what a correction adds ([`CORRECTION_MAX`]) below 4e28, a vertex or a
/// corner of a rest box at three times 1e9 below 2e38: `f32::MAX` is 3.4e38. Where a normal's
/// cofactors overflow, the rest normal stands for it.
pub const MAGNITUDE_MAX: f32 = 1.0e9;
/// How far a pose may carry a joint from its place in the rest pose, in the units of the model, for
/// every value to be finite.
pub const TRAVEL_MAX: f32 = 1.0e12;
/// Largest magnitude of any float of a correction, and of a fade's squared distances.
///
/// A kernel map is evaluated only where some centre is nearer than √1e6 = 1e3, so |x| < 1.1e6 there.
/// Sizes are below 65,536 and |G - rest| below 1.1e6, so a latent value stays below 2 * 65,536 * 1e6 *
/// 1.1e6 < 1.5e17, an output below 65,536 * 1e6 * 1.5e17 < 1e28, and a rigid pose's turn of it below
/// 3e28: far from `f32::MAX`.
pub const CORRECTION_MAX: f32 = 1.0e6;

/// The whole file as one postcard message, as a writer has it: what stands before the byte strings has a
/// fixed place, where a reader finds it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct File<'a> {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`VERSION`].
    pub version: u8,
    /// Required features, little-endian.
    pub features: [u8; 4],
    /// [`checksum`] of the file, little-endian.
    pub checksum: [u8; 4],
    /// A [`super::Space`].
    pub space: [u8; 8],
    /// Rows of [`super::PartRow::BYTES`].
    #[serde(serialize_with = "at_once")]
    pub parts: &'a [u8],
    /// Rows of [`super::SectionRow::BYTES`], by ascending offset.
    #[serde(serialize_with = "at_once")]
    pub sections: &'a [u8],
    /// Zeros that bring the blob to its alignment.
    #[serde(serialize_with = "at_once")]
    pub padding: &'a [u8],
    /// Every section.
    #[serde(serialize_with = "at_once")]
    pub blob: &'a [u8],
}

/// Writes bytes as postcard would one by one, but in one call: under Miri a writer takes seconds else.
fn at_once<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytes)
}

/// Computes the CRC-32 (ISO-HDLC) of a file with its own checksum field taken as zero.
pub fn checksum(file: &[u8]) -> u32 {
    let (head, rest) = file.split_at_checked(CHECKSUM_OFFSET).unwrap_or((file, &[]));
    let (zeros, rest) = rest.split_at_checked(4).map_or((0, rest), |(_, rest)| (4, rest));
    crc::of(&[head, [0; 4].get(..zeros).unwrap_or_default(), rest])
}
