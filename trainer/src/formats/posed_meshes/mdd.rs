//! Lightwave motion designer caches, `.mdd`: counts, the time of each frame, points; big-endian.

use super::data::PosedMeshes;
use super::error::PointCacheError;
use super::points::Counts;
use crate::formats::error::FormatError;
use std::path::Path;

/// Bytes before the times: the counts of frames and of points.
const HEADER_BYTES: usize = 8;

/// Reads a file.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::PointCache`]
pub(crate) fn read(path: &Path) -> Result<PosedMeshes, FormatError> {
    Ok(parse(&std::fs::read(path).map_err(FormatError::Read)?)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// [`PointCacheError::Count`], [`PointCacheError::TooMany`] and [`PointCacheError::Length`]
pub(super) fn parse(bytes: &[u8]) -> Result<PosedMeshes, PointCacheError> {
    let Some(&[a, b, c, d, e, f, g, h]) = bytes.first_chunk::<HEADER_BYTES>() else {
        let (expected, found) = (HEADER_BYTES as u64, bytes.len() as u64);
        return Err(PointCacheError::Length { expected, found });
    };
    let frames = i32::from_be_bytes([a, b, c, d]);
    let counts = Counts::new(i32::from_be_bytes([e, f, g, h]), frames)?;
    counts.read(bytes, HEADER_BYTES as u64 + 4 * counts.frame_len(), f32::from_be_bytes)
}
