//! The body that point caches have in common: frame by frame, x, y and z of each point in f32.

use rayon::prelude::*;

use super::data::PosedMeshes;
use super::error::PointCacheError;

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
