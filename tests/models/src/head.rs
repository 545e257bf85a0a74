//! The head of a file: where what stands in it.

use std::ops::Range;

/// First bytes of every file.
pub const MAGIC: Range<usize> = 0..4;
/// The version's byte.
pub const VERSION: usize = 4;
/// Bits of what a reader must know.
pub const FEATURES: Range<usize> = 5..9;
/// The checksum of the whole file.
pub const CHECKSUM: Range<usize> = 9..13;
/// Axes and unit.
pub const SPACE: Range<usize> = 13..21;
/// Bytes of the head.
pub const BYTES: usize = 21;

/// The head of version 8: no features, no checksum yet, axes and unit not told, right-handed.
pub const SOUND: [u8; BYTES] = *b"SNEW\x08\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0\0";
