//! Skinning of positions by a palette of columns, which a job writes to its scratch.
//!
//! A transform is two registers of two columns. The operations on a float and their order are those of
//! [`blend`](super::blend), so the bits are equal.

use super::blend::Fours;
use super::output::{Output, put};
use crate::error::{Argument, CallError};
use crate::linear::{Le, Matrix3x4, floats};
use core::cell::Cell;
use core::fmt;
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, prelude::*};
use wide::bytemuck;

/// Floats of a transform, and of a cache line.
const LINE: usize = 16;

/// Four columns of a transform, aligned.
type Columns = [wide::f32x4; 4];

/// Scratch of a job.
#[derive(Default)]
pub(super) struct Scratch<'a>(&'a mut [f32]);

/// A clone has no scratch, because two jobs cannot write to it at once.
impl Clone for Scratch<'_> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Scratch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Scratch").field(&self.0.len()).finish()
    }
}

impl<'a> Scratch<'a> {
    /// Returns the floats of scratch for a palette, from any address.
    pub(super) const fn least(palette_len: usize) -> usize {
        LINE * palette_len + LINE - 1
    }

    pub(super) const fn new(floats: &'a mut [f32]) -> Self {
        Self(floats)
    }

    /// Refuses scratch that is too short for a palette; a job without scratch is sound.
    pub(super) const fn check(&self, palette_len: usize) -> Result<(), CallError> {
        if self.0.is_empty() {
            return Ok(());
        }
        Argument::Scratch.check_least(Self::least(palette_len), self.0.len())
    }

    /// Skins positions. `None` without scratch or vector units; then nothing is written.
    ///
    /// - `rest`, `influences`: of the vertices of the range.
    pub(super) fn positions(
        &mut self,
        palette: &[Matrix3x4],
        rest: &[[Le; 3]],
        influences: Fours<'_>,
        out: &Output<'_>,
    ) -> Option<()> {
        let level = Level::try_detect().unwrap_or(Level::baseline());
        if level.is_fallback() {
            return None;
        }
        positions(level, transposed(palette, self.0)?, rest, influences, out);
        Some(())
    }
}

/// Writes the columns of a palette to scratch, each transform into a cache line. `None` without scratch.
fn transposed<'s>(palette: &[Matrix3x4], scratch: &'s mut [f32]) -> Option<&'s [Columns]> {
    let past = scratch.as_ptr().addr() / size_of::<f32>() % LINE;
    let lines = scratch.get_mut((LINE - past) % LINE..)?.get_mut(..LINE * palette.len())?;
    let columns: &mut [Columns] = bytemuck::try_cast_slice_mut(lines).ok()?;
    for (out, [x, y, z]) in columns.iter_mut().zip(palette) {
        let column = |c: usize| [x[c], y[c], z[c], 0.0];
        *out = bytemuck::cast([column(0), column(1), column(2), column(3)]);
    }
    Some(columns)
}

/// Skins positions. A loop ends early only if the bytes of the file have changed since loading.
// Not inlined: then the type of `columns` tells the compiler that the loads are aligned.
#[inline(never)]
fn positions(
    level: Level,
    columns: &[Columns],
    rest: &[[Le; 3]],
    influences: Fours<'_>,
    out: &Output<'_>,
) {
    if out.stride == 3 {
        dispatch!(level, simd => packed(simd, columns, rest, influences, out));
    } else {
        dispatch!(level, simd => strided(simd, columns, rest, influences, out));
    }
}

/// Skins positions that follow one another.
#[inline(always)]
fn packed<S: Simd>(
    simd: S,
    columns: &[Columns],
    rest: &[[Le; 3]],
    (indices, weights): Fours<'_>,
    out: &Output<'_>,
) -> Option<()> {
    let mut vertices = rest.iter().zip(indices.iter().zip(weights));
    let mut floats = out.floats;
    let (last, of_last) = vertices.next_back()?;
    for (rest, influences) in vertices {
        let moved = moved(simd, columns, rest, influences)?;
        // One store of four floats: the next vertex overwrites the fourth.
        let four: &[Cell<f32>; 4] = floats.first_chunk()?;
        four.iter().zip(moved).for_each(|(out, value)| out.set(value));
        floats = floats.get(3..)?;
    }
    let [x, y, z, _] = moved(simd, columns, last, of_last)?;
    put(floats, [x, y, z])
}

/// Skins positions at a stride.
#[inline(always)]
fn strided<S: Simd>(
    simd: S,
    columns: &[Columns],
    rest: &[[Le; 3]],
    (indices, weights): Fours<'_>,
    out: &Output<'_>,
) -> Option<()> {
    let vertices = rest.iter().zip(indices.iter().zip(weights));
    // Chunks of 0 would panic.
    for ((rest, influences), out) in vertices.zip(out.floats.chunks(out.stride.max(1))) {
        let [x, y, z, _] = moved(simd, columns, rest, influences)?;
        put(out, [x, y, z])?;
    }
    Some(())
}

/// Returns the posed position of a vertex, and a fourth float.
///
/// `None` if an index is beyond the palette.
#[inline(always)]
fn moved<S: Simd>(
    simd: S,
    columns: &[Columns],
    rest: &[Le; 3],
    (indices, weights): (&[[u8; 2]; 4], &[Le; 4]),
) -> Option<[f32; 4]> {
    let mut sums: Option<[f32x8<S>; 2]> = None;
    for (index, weight) in indices.iter().zip(weights) {
        let columns = columns.get(usize::from(u16::from_le_bytes(*index)))?;
        let [first, second]: &[[f32; 8]; 2] = bytemuck::cast_ref(columns);
        let weight = f32x8::splat(simd, f32::from_le_bytes(*weight));
        let first = f32x8::load_array_ref(simd, first) * weight;
        let second = f32x8::load_array_ref(simd, second) * weight;
        sums = Some(match sums {
            Some([a, b]) => [a + first, b + second],
            None => [first, second],
        });
    }
    let [first, second] = sums?;
    let [x, y, z] = floats(rest);
    let x_and_y = simd.combine_f32x4(f32x4::splat(simd, x), f32x4::splat(simd, y));
    let (a, b) = simd.split_f32x8(first * x_and_y);
    let (c, d) = simd.split_f32x8(second);
    // `blend` starts at 0, so its result is never -0.
    Some(((((a + b) + c * f32x4::splat(simd, z)) + d) + 0.0).to_array())
}
