//! PointCache2 files, `.pc2`, as 3ds Max, Maya and Blender write them; little-endian.
//! Lightwave motion designer caches, `.mdd`: counts, the time of each frame, points; big-endian.
//! The body that point caches have in common: frame by frame, x, y and z of each point in f32.

use super::{PointCacheError, PosedMeshes};
use crate::files;
use crate::formats::error::{FileError, FormatError};
use rayon::prelude::*;
use std::io;
use std::path::Path;

const MAGIC: [u8; 12] = *b"POINTCACHE2\0";
const VERSION: i32 = 1;

/// Bytes before the points: magic, version, points, first frame, step, frames.
const PC2_HEADER_BYTES: usize = 32;

/// Reads a file.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::PointCache`]
pub(crate) fn read_pc2(path: &Path) -> Result<PosedMeshes, FormatError> {
    Ok(parse_pc2(&std::fs::read(path).map_err(FormatError::Read)?)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// - [`PointCacheError::NotPointCache`] for another magic or version.
/// - [`PointCacheError::Count`], [`PointCacheError::TooMany`] and [`PointCacheError::Length`] for counts that are not
///   positive or do not match the file's length.
pub(super) fn parse_pc2(bytes: &[u8]) -> Result<PosedMeshes, PointCacheError> {
    if !bytes.starts_with(&MAGIC) {
        let reason = "it does not begin with POINTCACHE2".to_owned();
        return Err(PointCacheError::NotPointCache { reason });
    }
    let Some(header) = bytes.first_chunk::<PC2_HEADER_BYTES>() else {
        let (expected, found) = (PC2_HEADER_BYTES as u64, bytes.len() as u64);
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
    Counts::new(whole(16), whole(28))?.read(bytes, PC2_HEADER_BYTES as u64, f32::from_le_bytes)
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
    let mut bytes = Vec::with_capacity(PC2_HEADER_BYTES + 12 * len);
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

/// Bytes before the times: the counts of frames and of points.
const MDD_HEADER_BYTES: usize = 8;

/// Reads a file.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::PointCache`]
pub(crate) fn read_mdd(path: &Path) -> Result<PosedMeshes, FormatError> {
    Ok(parse_mdd(&std::fs::read(path).map_err(FormatError::Read)?)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// [`PointCacheError::Count`], [`PointCacheError::TooMany`] and [`PointCacheError::Length`]
pub(super) fn parse_mdd(bytes: &[u8]) -> Result<PosedMeshes, PointCacheError> {
    let Some(&[a, b, c, d, e, f, g, h]) = bytes.first_chunk::<MDD_HEADER_BYTES>() else {
        let (expected, found) = (MDD_HEADER_BYTES as u64, bytes.len() as u64);
        return Err(PointCacheError::Length { expected, found });
    };
    let frames = i32::from_be_bytes([a, b, c, d]);
    let counts = Counts::new(i32::from_be_bytes([e, f, g, h]), frames)?;
    counts.read(bytes, MDD_HEADER_BYTES as u64 + 4 * counts.frame_len(), f32::from_be_bytes)
}

/// Bytes of a point.
const POINT_BYTES: u64 = 12;

/// How many points and frames a header counts, one of each at least.
#[derive(Clone, Copy)]
pub(super) struct Counts {
    vertex_len: u64,
    frame_len: u64,
}

impl Counts {
    /// Checks the counts of a header.
    pub(super) fn new(points: i32, frames: i32) -> Result<Self, PointCacheError> {
        let positive = |what, found: i32| match u64::try_from(found) {
            Ok(count) if count > 0 => Ok(count),
            _ => Err(PointCacheError::Count { what, found }),
        };
        Ok(Self { vertex_len: positive("points", points)?, frame_len: positive("frames", frames)? })
    }

    /// Counts the frames.
    pub(super) fn frame_len(self) -> u64 {
        self.frame_len
    }

    /// Reads the points of a file, which must fill it from `begin` to its end.
    pub(super) fn read(
        self,
        bytes: &[u8],
        begin: u64,
        number: fn([u8; 4]) -> f32,
    ) -> Result<PosedMeshes, PointCacheError> {
        let (points, frames) = (self.vertex_len, self.frame_len);
        // Two counts of 31 bits: their product fits 64.
        let expected = (points * frames).checked_mul(POINT_BYTES);
        let expected = expected.and_then(|bytes| bytes.checked_add(begin));
        let expected = expected.ok_or(PointCacheError::TooMany { points, frames })?;
        let found = bytes.len() as u64;
        if found != expected {
            return Err(PointCacheError::Length { expected, found });
        }
        let (points, _) = bytes[begin as usize..].as_chunks::<{ POINT_BYTES as usize }>();
        let point = |&[a, b, c, d, e, f, g, h, i, j, k, l]: &[u8; 12]| {
            [[a, b, c, d], [e, f, g, h], [i, j, k, l]].map(|bytes| f64::from(number(bytes)))
        };
        let vertices = points.par_iter().map(point).collect();
        Ok(PosedMeshes::bare(self.vertex_len as usize, vertices))
    }
}
