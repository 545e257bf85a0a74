//! Skinning of positions by a palette of columns, which a job writes to its scratch.
//!
//! A transform is two registers of two columns. The operations on a float and their order are those of
//! [`blend`](super::blend), so the bits are equal.

use super::blend::Fours;
use super::output::{Output, put};
use crate::error::{Argument, CallError};
use crate::linear::{Le, Matrix3x4, floats};
use core::cell::Cell;
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, prelude::*};

/// A transform in the scratch of a job: a cache line with pairs of columns.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct CacheLine([[[f32; 4]; 2]; 2]);

/// Scratch of a job, empty without.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scratch<'a>(&'a [Cell<CacheLine>]);

impl<'a> Scratch<'a> {
    pub(super) fn new(lines: &'a mut [CacheLine]) -> Self {
        Self(Cell::from_mut(lines).as_slice_of_cells())
    }

    /// Returns the cache lines of scratch for a palette.
    pub(super) const fn least(palette_len: usize) -> usize {
        palette_len
    }

    /// Refuses scratch that is too short for a palette.
    pub(super) fn check(&self, palette_len: usize) -> Result<(), CallError> {
        match self.0.len() {
            0 => Ok(()),
            len => Argument::Scratch.check_least(palette_len, len),
        }
    }

    /// Skins positions. `None` without scratch or vector units; then nothing is written.
    ///
    /// - `rest`, `influences`: of the vertices of the range.
    pub(super) fn positions(
        &self,
        palette: &[Matrix3x4],
        rest: &[[Le; 3]],
        influences: Fours<'_>,
        out: &Output<'_>,
    ) -> Option<()> {
        let level = Level::try_detect().unwrap_or(Level::baseline());
        let columns = self.0.get(..palette.len()).filter(|_| !level.is_fallback())?;
        for (out, [x, y, z]) in columns.iter().zip(palette) {
            let column = |c: usize| [x[c], y[c], z[c], 0.0];
            let [x, y, z, shift] = [column(0), column(1), column(2), column(3)];
            out.set(CacheLine([[x, y], [z, shift]]));
        }
        // The loops end early only if the bytes of the file have changed since loading.
        if out.stride == 3 {
            dispatch!(level, simd => packed(simd, columns, rest, influences, out));
        } else {
            dispatch!(level, simd => strided(simd, columns, rest, influences, out));
        }
        Some(())
    }
}

/// Skins positions that follow one another.
#[inline(always)]
fn packed<S: Simd>(
    simd: S,
    columns: &[Cell<CacheLine>],
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
    columns: &[Cell<CacheLine>],
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
    columns: &[Cell<CacheLine>],
    rest: &[Le; 3],
    (indices, weights): (&[[u8; 2]; 4], &[Le; 4]),
) -> Option<[f32; 4]> {
    let mut sums: Option<[f32x8<S>; 2]> = None;
    for (index, weight) in indices.iter().zip(weights) {
        let CacheLine(columns) = columns.get(usize::from(u16::from_le_bytes(*index)))?.get();
        let weight = f32x8::splat(simd, f32::from_le_bytes(*weight));
        // Written out: `map` is not surely inlined, and would then compute without the level's instructions.
        let [[a, b], [c, d]] = columns;
        let first = f32x4::load_array(simd, a).combine(f32x4::load_array(simd, b)) * weight;
        let second = f32x4::load_array(simd, c).combine(f32x4::load_array(simd, d)) * weight;
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
