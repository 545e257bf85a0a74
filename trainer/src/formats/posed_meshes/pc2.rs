//! PointCache2 files, `.pc2`, as 3ds Max, Maya and Blender write them; little-endian.

use std::io;
use std::path::Path;

use super::data::PosedMeshes;
use super::error::PointCacheError;
use super::points::Counts;
use crate::files;
use crate::formats::error::{FileError, FormatError};

const MAGIC: [u8; 12] = *b"POINTCACHE2\0";
const VERSION: i32 = 1;

/// Bytes before the points: magic, version, points, first frame, step, frames.
const HEADER_BYTES: usize = 32;

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
/// - [`PointCacheError::NotPointCache`] for another magic or version.
/// - [`PointCacheError::Count`], [`PointCacheError::TooMany`] and [`PointCacheError::Length`] for counts that are not
///   positive or do not match the file's length.
pub(super) fn parse(bytes: &[u8]) -> Result<PosedMeshes, PointCacheError> {
    if !bytes.starts_with(&MAGIC) {
        let reason = "it does not begin with POINTCACHE2".to_owned();
        return Err(PointCacheError::NotPointCache { reason });
    }
    let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
        let (expected, found) = (HEADER_BYTES as u64, bytes.len() as u64);
        return Err(PointCacheError::Length { expected, found });
    };
    let whole = |at: usize| {
        i32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    let version = whole(12);
    if version != VERSION {
        return Err(PointCacheError::NotPointCache {
            reason: format!("it is of version {version}"),
        });
    }
    Counts::new(whole(16), whole(28))?.read(bytes, HEADER_BYTES as u64, f32::from_le_bytes)
}

/// Writes posed positions (N x V, frame-major) as a PointCache2 file in single precision, its first
/// frame 0 and its step 1. The same positions give the same bytes.
///
/// # Errors
/// A [`FileError`] that names the file, if it cannot be written, or if `vertices` are no whole frames
/// of `vertex_len` or more than the format can count.
pub fn save_pc2(path: &Path, vertex_len: usize, vertices: &[[f64; 3]]) -> Result<(), FileError> {
    encode(vertex_len, vertices)
        .and_then(|bytes| files::write(path, &bytes))
        .map_err(|error| FileError { file: path.to_owned(), error: FormatError::Write(error) })
}

fn encode(vertex_len: usize, vertices: &[[f64; 3]]) -> io::Result<Vec<u8>> {
    let refuse = |reason: String| io::Error::new(io::ErrorKind::InvalidInput, reason);
    let len = vertices.len();
    if vertex_len == 0 || len == 0 || !len.is_multiple_of(vertex_len) {
        return Err(refuse(format!("{len} positions are no whole frames of {vertex_len}")));
    }
    let count = |len: usize| {
        i32::try_from(len).map_err(|_| refuse(format!("{len} is more than a .pc2 can count")))
    };
    let (points, frames) = (count(vertex_len)?, count(len / vertex_len)?);
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 12 * len);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(points.to_le_bytes());
    bytes.extend(0f32.to_le_bytes());
    bytes.extend(1f32.to_le_bytes());
    bytes.extend(frames.to_le_bytes());
    for number in vertices.as_flattened() {
        bytes.extend((*number as f32).to_le_bytes());
    }
    Ok(bytes)
}
