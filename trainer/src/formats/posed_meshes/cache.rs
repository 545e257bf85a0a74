//! Point caches: PointCache2 (`.pc2`) and Lightwave motion designer (`.mdd`).
//!
//! Both store the counts of points and frames, then x, y and z of each point in f32, frame by frame. A `.pc2`, as
//! written by 3ds Max, Maya and Blender, is little-endian. An `.mdd` also stores the time of each frame and is
//! big-endian.

use super::PosedMeshes;
use crate::{Error, files};
use rayon::prelude::*;
use std::fmt::Display;
use std::io;
use std::path::Path;

const MAGIC: [u8; 12] = *b"POINTCACHE2\0";
const VERSION: i32 = 1;

/// Bytes before the points: magic, version, points, first frame, step, frames.
const PC2_HEADER_BYTES: usize = 32;

/// Bytes before the times: the counts of frames and of points.
const MDD_HEADER_BYTES: usize = 8;

/// Bytes of a point.
const POINT_BYTES: u64 = 12;

/// Reads a `.pc2` file.
///
/// # Errors
/// The file cannot be read, is no point cache, or its counts do not match its length.
pub(crate) fn read_pc2(path: &Path) -> Result<PosedMeshes, Error> {
    parse_pc2(&std::fs::read(path).map_err(Error::read)?)
}

/// Parses the bytes of a `.pc2` file.
///
/// # Errors
/// The magic or version is another, or the counts are not positive or do not match the length of the file.
pub(super) fn parse_pc2(bytes: &[u8]) -> Result<PosedMeshes, Error> {
    if !bytes.starts_with(&MAGIC) {
        return Err(no_point_cache("it does not begin with POINTCACHE2"));
    }
    let Some(header) = bytes.first_chunk::<PC2_HEADER_BYTES>() else {
        return Err(wrong_length(PC2_HEADER_BYTES as u64, bytes.len()));
    };
    let whole = |at: usize| {
        i32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    let version = whole(12);
    if version != VERSION {
        return Err(no_point_cache(format!("it is of version {version}")));
    }
    points(bytes, [whole(16), whole(28)], [PC2_HEADER_BYTES as u64, 0], f32::from_le_bytes)
}

/// Writes posed positions (N x V, frame-major) as a PointCache2 file in single precision, first frame 0, step 1.
/// Equal positions give equal bytes.
///
/// # Errors
/// The file cannot be written, `vertices` are not whole frames of `vertex_len`, or the format cannot count them.
pub fn save_pc2(path: &Path, vertex_len: usize, vertices: &[[f64; 3]]) -> Result<(), Error> {
    encode(vertex_len, vertices)
        .and_then(|bytes| files::write(path, &bytes))
        .map_err(|error| Error::write(error).in_file(path))
}

/// Reads an `.mdd` file.
///
/// # Errors
/// The file cannot be read, or its counts do not match its length.
pub(crate) fn read_mdd(path: &Path) -> Result<PosedMeshes, Error> {
    parse_mdd(&std::fs::read(path).map_err(Error::read)?)
}

/// Parses the bytes of an `.mdd` file.
///
/// # Errors
/// The counts are not positive, or do not match the length of the file.
pub(super) fn parse_mdd(bytes: &[u8]) -> Result<PosedMeshes, Error> {
    let Some(&[a, b, c, d, e, f, g, h]) = bytes.first_chunk::<MDD_HEADER_BYTES>() else {
        return Err(wrong_length(MDD_HEADER_BYTES as u64, bytes.len()));
    };
    let counts = [[e, f, g, h], [a, b, c, d]].map(i32::from_be_bytes);
    points(bytes, counts, [MDD_HEADER_BYTES as u64, 4], f32::from_be_bytes)
}

/// Reads the points of a file; they must reach from its header exactly to the end of the file.
///
/// - `points`, `frames`: the counts of the header, at least 1 each.
/// - `header`, `time`: bytes of the header without times, and of the time of a frame.
fn points(
    bytes: &[u8],
    [points, frames]: [i32; 2],
    [header, time]: [u64; 2],
    number: fn([u8; 4]) -> f32,
) -> Result<PosedMeshes, Error> {
    let positive = |what: &str, found: i32| match u64::try_from(found) {
        Ok(count) if count > 0 => Ok(count),
        _ => Err(Error::damaged(format!(
            "counts {found} {what}, expected 1 at least; export the point cache again"
        ))),
    };
    let (vertex_len, frame_len) = (positive("points", points)?, positive("frames", frames)?);
    let begin = header + time * frame_len;
    // The product of two counts of 31 bits fits 64 bits.
    let expected = (vertex_len * frame_len).checked_mul(POINT_BYTES);
    let expected = expected.and_then(|bytes| bytes.checked_add(begin));
    let too_many = || {
        Error::damaged(format!(
            "counts {points} points in {frames} frames, more than a file can hold; export the \
             point cache again"
        ))
    };
    let expected = expected.ok_or_else(too_many)?;
    if bytes.len() as u64 != expected {
        return Err(wrong_length(expected, bytes.len()));
    }
    let points = bytes[begin as usize..].as_chunks::<4>().0.as_chunks::<3>().0;
    let point = |point: &[[u8; 4]; 3]| point.map(|bytes| f64::from(number(bytes)));
    Ok(PosedMeshes::bare(vertex_len as usize, points.par_iter().map(point).collect()))
}

fn no_point_cache(reason: impl Display) -> Error {
    Error::damaged(format!(
        "is no PointCache2 file of version 1: {reason}; export it as .pc2 again"
    ))
}

fn wrong_length(expected: u64, found: usize) -> Error {
    Error::damaged(format!(
        "should have {expected} bytes by its header, found {found}; export the point cache again"
    ))
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
