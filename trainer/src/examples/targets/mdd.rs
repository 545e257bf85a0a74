//! Lightwave motion designer caches, `.mdd`: counts, the time of each frame, points; big-endian.

use super::super::TargetsError;
use super::Targets;
use super::points::Counts;

/// Bytes before the times: the counts of frames and of points.
const HEADER_BYTES: usize = 8;

/// Reads the bytes of a file.
///
/// # Errors
/// [`TargetsError::PointCacheCount`] and [`TargetsError::PointCacheLength`]
pub(super) fn parse(bytes: &[u8]) -> Result<Targets, TargetsError> {
    let Some(&[a, b, c, d, e, f, g, h]) = bytes.first_chunk::<HEADER_BYTES>() else {
        let (expected, found) = (HEADER_BYTES as u64, bytes.len() as u64);
        return Err(TargetsError::PointCacheLength { expected, found });
    };
    let frames = i32::from_be_bytes([a, b, c, d]);
    let counts = Counts::new(i32::from_be_bytes([e, f, g, h]), frames)?;
    counts.read(bytes, HEADER_BYTES as u64 + 4 * counts.frame_len(), f32::from_be_bytes)
}
