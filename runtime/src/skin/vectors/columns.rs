//! Skinning of positions by a palette of columns, which a job writes to its scratch. A transform is two registers of
//! two columns.

use super::super::counts::EIGHT;
use super::super::job::SkinJob;
use super::super::output::{Output, put};
use super::super::scratch::CacheLine;
use super::super::view::Row;
use core::cell::Cell;
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, prelude::*};

/// Rows of a block of vertices with four influences each: rest positions, indices and weights.
type Block<'b> = ((&'b [Row; 3], &'b [[[u8; 2]; EIGHT]; 4]), &'b [Row; 4]);

/// Skins positions. `None` without scratch, with another number of influences than four, or for a job with a remap or a
/// rest mesh; then nothing is written.
pub(super) fn run(level: Level, job: &SkinJob<'_>) -> Option<()> {
    let SkinJob { skin, palette, rest, scratch, .. } = job;
    let columns = scratch.lines(palette.len())?;
    if skin.influence_len() != 4 || job.remap.is_some() || rest.positions.is_some() {
        return None;
    }
    for (out, [[x0, y0, z0, w0], [x1, y1, z1, w1], [x2, y2, z2, w2]]) in
        columns.iter().zip(*palette)
    {
        let first = [*x0, *x1, *x2, 0.0, *y0, *y1, *y2, 0.0];
        out.set(CacheLine([first, [*z0, *z1, *z2, 0.0, *w0, *w1, *w2, 0.0]]));
    }
    let out = job.positions.as_ref()?;
    dispatch!(level, simd => all(simd, job, columns, out))
}

#[inline(always)]
fn all<S: Simd>(
    simd: S,
    job: &SkinJob<'_>,
    columns: &[Cell<CacheLine>],
    out: &Output<'_>,
) -> Option<()> {
    let range = job.range();
    let (skin, first) = (&job.skin, range.start / EIGHT);
    let blocks = skin.positions().iter().zip(skin.indices().as_chunks().0);
    let blocks = blocks.zip(skin.weights().as_chunks().0).skip(first);
    let mut floats = out.floats;
    let mut left = range.len();
    let mut lanes = range.start % EIGHT..EIGHT;
    for block in blocks {
        lanes.end = lanes.end.min(lanes.start + left);
        if out.stride == 3 && lanes == (0..EIGHT) {
            let floats = floats.first_chunk()?;
            // The last influences are often unused in all vertices of a block.
            match influence_len(block.1) {
                1 => packed::<_, 1>(simd, columns, block, floats)?,
                2 => packed::<_, 2>(simd, columns, block, floats)?,
                3 => packed::<_, 3>(simd, columns, block, floats)?,
                _ => packed::<_, 4>(simd, columns, block, floats)?,
            }
        } else {
            // Chunks of 0 would panic.
            for (lane, out) in lanes.clone().zip(floats.chunks(out.stride.max(1))) {
                let [x, y, z, _] = moved::<_, 4>(simd, columns, block, lane % EIGHT)?;
                put(out, [x, y, z])?;
            }
        }
        left -= lanes.len();
        if left == 0 {
            break;
        }
        floats = floats.get(out.stride * lanes.len()..)?;
        lanes = 0..EIGHT;
    }
    Some(())
}

/// Returns the number of influences in use by some vertex of a block.
#[inline(always)]
fn influence_len(weights: &[Row; 4]) -> usize {
    let is_used = |row: &Row| row.as_flattened().iter().fold(0, |all, byte| all | byte) > 0;
    weights.iter().rposition(is_used).map_or(1, |last| last + 1)
}

/// Skins a block whose positions follow one another.
#[inline(always)]
fn packed<S: Simd, const LEN: usize>(
    simd: S,
    columns: &[Cell<CacheLine>],
    block: Block<'_>,
    floats: &[Cell<f32>; 3 * EIGHT],
) -> Option<()> {
    for lane in 0..EIGHT - 1 {
        let moved = moved::<S, LEN>(simd, columns, block, lane)?;
        // One store: the next vertex overwrites the fourth float.
        let at = 3 * lane;
        let [x, y, z, w] = [&floats[at], &floats[at + 1], &floats[at + 2], &floats[at + 3]];
        x.set(moved[0]);
        y.set(moved[1]);
        z.set(moved[2]);
        w.set(moved[3]);
    }
    let [x, y, z, _] = moved::<S, LEN>(simd, columns, block, EIGHT - 1)?;
    floats[21].set(x);
    floats[22].set(y);
    floats[23].set(z);
    Some(())
}

/// Returns the posed position of a vertex, and a fourth float.
///
/// `None` if an index is beyond the palette.
#[inline(always)]
fn moved<S: Simd, const LEN: usize>(
    simd: S,
    columns: &[Cell<CacheLine>],
    (([x, y, z], indices), weights): Block<'_>,
    lane: usize,
) -> Option<[f32; 4]> {
    let mut sums: Option<[f32x8<S>; 2]> = None;
    for (indices, weights) in indices.iter().zip(weights).take(LEN) {
        let CacheLine([first, second]) =
            columns.get(usize::from(u16::from_le_bytes(indices[lane])))?.get();
        let weight = f32x8::splat(simd, f32::from_le_bytes(weights[lane]));
        let first = f32x8::load_array(simd, first) * weight;
        let second = f32x8::load_array(simd, second) * weight;
        sums = Some(match sums {
            Some([a, b]) => [a + first, b + second],
            None => [first, second],
        });
    }
    let [first, second] = sums?;
    let x = f32x4::splat(simd, f32::from_le_bytes(x[lane]));
    let y = f32x4::splat(simd, f32::from_le_bytes(y[lane]));
    let z = f32x4::splat(simd, f32::from_le_bytes(z[lane]));
    let ((a, b), (c, d)) = ((first * x.combine(y)).split(), second.split());
    // The other loops start at 0, so their results are never -0.
    Some((((a + b) + c * z + d) + 0.0).to_array())
}
