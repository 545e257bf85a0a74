//! The file: its layout, defined here once for reader and writer, and its checks.
//!
//! `FORMAT.md` is the byte-level contract. A file is one postcard message, [`File`].

mod group;
mod manifest;
mod validate;

pub use group::GroupRow;
pub use manifest::{
    Certificate, EnvelopeCounts, KEY_WORDS, NO_JOINT, PartKind, PartRow, Predictor, Presence,
    SectionKind, SectionRow,
};
pub(crate) use validate::read;

use serde::{Deserialize, Serialize, Serializer};

/// First bytes of every file.
pub const MAGIC: [u8; 4] = *b"SNEW";
/// The version that this crate reads and that the trainer writes.
pub const VERSION: u8 = 2;
/// Feature bits that a reader must know; this version has none.
pub const FEATURES: u32 = 0;
/// Powers of two that sections may be aligned to: 16 bytes to 4096.
pub const ALIGNMENT_LOG2: core::ops::RangeInclusive<u8> = 4..=12;
/// Most rows of the part table.
pub const PARTS_MAX: usize = 8;
/// Most rows of the section table.
pub const SECTIONS_MAX: usize = 32;
/// Where the checksum stands in the file.
pub const CHECKSUM_OFFSET: usize = 10;

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
/// How far the products of an inverse bind matrix's rows may be from those of a rotation: what
/// singular values within 1e-2 of 1 leave, which is the least rigid that is trained on, and half of
/// it again. Of other matrices a pose would be no rigid motion, and its logarithm no number.
pub const BIND_TOLERANCE: f32 = 0.03;
/// Largest Frobenius norm of a twist matrix; angles stay accurate to 4e-4 even there.
pub const TWIST_MAX: f32 = 1024.0;
/// Largest magnitude of any float of a correction, and of a fade's squared distances.
///
/// A map is evaluated only where some centre is nearer than √1e6 = 1e3, so |x| < 1.1e6 there. Sizes
/// are below 65,536 and |G - rest| below 1.1e6, so a latent value stays below 2 * 65,536 * 1e6 *
/// 1.1e6 < 1.5e17, an output below 65,536 * 1e6 * 1.5e17 < 1e28, and a rigid pose's turn of it below
/// 3e28: far from `f32::MAX`.
pub const CORRECTION_MAX: f32 = 1.0e6;
/// How far the weights of a vertex may sum from one: rounding of 32 influences is below 4e-6.
pub const WEIGHT_SUM_TOLERANCE: f32 = 1.0e-5;

/// The whole file as one postcard message.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct File<'a> {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`VERSION`].
    pub version: u8,
    /// Sections and the blob start at multiples of two to this power.
    pub alignment_log2: u8,
    /// Required features, little-endian.
    pub features: [u8; 4],
    /// [`checksum`] of the file, little-endian.
    pub checksum: [u8; 4],
    /// Rows of [`PartRow::BYTES`].
    #[serde(serialize_with = "at_once")]
    pub parts: &'a [u8],
    /// Rows of [`SectionRow::BYTES`], by ascending offset.
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

/// How the checksum is computed: by a table of 1 KiB; on bare targets, where flash is dear and a file is
/// loaded once, bit by bit.
#[cfg(not(target_os = "none"))]
type Steps = crc::Table<1>;
#[cfg(target_os = "none")]
type Steps = crc::NoTable;

/// Computes the CRC-32 (ISO-HDLC) of a file with its own checksum field taken as zero.
pub fn checksum(file: &[u8]) -> u32 {
    static CRC: crc::Crc<u32, Steps> = crc::Crc::<u32, Steps>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    let (head, rest) = file.split_at_checked(CHECKSUM_OFFSET).unwrap_or((file, &[]));
    digest.update(head);
    if let Some((_, rest)) = rest.split_at_checked(4) {
        digest.update(&[0; 4]);
        digest.update(rest);
    }
    digest.finalize()
}

/// The decoded head of a file whose tables have been checked.
#[derive(Clone, Copy)]
pub(crate) struct Manifest<'a> {
    pub(crate) parts: &'a [[u8; PartRow::BYTES]],
    pub(crate) sections: &'a [[u8; SectionRow::BYTES]],
    pub(crate) blob: &'a [u8],
}

impl<'a> Manifest<'a> {
    /// Lists the section table.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = SectionRow> + use<'a> {
        self.sections.iter().map(SectionRow::from_bytes)
    }

    /// Returns the content of a section; rows of a checked manifest always have theirs.
    pub(crate) fn bytes(&self, row: SectionRow) -> &'a [u8] {
        let (offset, len) = (row.offset as usize, row.bytes as usize);
        self.blob.get(offset..).and_then(|tail| tail.get(..len)).unwrap_or_default()
    }

    /// Finds a part's section of one kind.
    pub(crate) fn find(&self, part: usize, kind: SectionKind) -> Option<&'a [u8]> {
        self.rows()
            .find(|row| usize::from(row.part) == part && row.kind == kind.number())
            .map(|row| self.bytes(row))
    }
}
