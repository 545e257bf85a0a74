//! Skinning of eight vertices at a time, by the rows of their transforms.

use super::super::counts::EIGHT;
use super::super::job::SkinJob;
use super::super::normals::{Frame, side};
use super::super::output::Output;
use super::block::{Block, File, Gathered, MOST};
use super::copies::{Copies, Source};
use crate::linear::{Matrix3x4, cross, dot};
use crate::vectors::{are_normal, columns, halves, read, rows};
use core::cell::Cell;
use core::ops::Range;
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, prelude::*};

/// Skins a job. `None` without influences or with too many; then nothing is written.
pub(super) fn run(level: Level, job: &SkinJob<'_>) -> Option<()> {
    if !(1..=MOST).contains(&job.skin.influence_len()) {
        return None;
    }
    let rest = &job.rest;
    let is_given = rest.positions.is_some() || rest.normals.is_some() || rest.tangents.is_some();
    let directions = match (&job.normals, &job.tangents) {
        (None, None) => 0,
        (Some(_), None) => 1,
        _ => 2,
    };
    let is_corrected = job.skin.has_coefficients() && directions > 0;
    match (is_corrected, directions, job.remap.is_some() || is_given) {
        (false, 0, false) => dispatch!(level, simd => plain::<_, false, 0>(simd, job)),
        (false, 1, false) => dispatch!(level, simd => plain::<_, false, 1>(simd, job)),
        (false, _, false) => dispatch!(level, simd => plain::<_, false, 2>(simd, job)),
        (true, 1, false) => dispatch!(level, simd => plain::<_, true, 1>(simd, job)),
        (true, _, false) => dispatch!(level, simd => plain::<_, true, 2>(simd, job)),
        (false, _, true) => dispatch!(level, simd => changed::<_, false>(simd, job)),
        (true, _, true) => dispatch!(level, simd => changed::<_, true>(simd, job)),
    }
}

/// Skins the vertices of a job without a remap and a rest mesh.
///
/// - `CORRECTED`: whether the skin has tangent coefficients, and the job needs them.
#[inline(always)]
fn plain<S: Simd, const CORRECTED: bool, const DIRECTIONS: usize>(
    simd: S,
    job: &SkinJob<'_>,
) -> Option<()> {
    let (range, file) = (job.range(), File::new(&job.skin));
    let (palette, side) = (job.palette, side(job.palette));
    // Each block is written after the next is posed: square roots and divisions take long.
    let mut last: Option<Posed<S>> = None;
    let mut done = 0;
    // The first and the last block may be parts.
    let mut lane = range.start % EIGHT;
    while done < range.len() {
        let lanes = lane..EIGHT.min(lane + range.len() - done);
        let posed = pose::<S, CORRECTED, DIRECTIONS>(
            simd,
            &file.block(range.start + done)?,
            palette,
            side,
        )?;
        if let Some(last) = &last {
            last.put::<DIRECTIONS>(job)?;
        }
        last = Some(Posed { first: done, lanes: lanes.clone(), ..posed });
        (lane, done) = (0, done + lanes.len());
    }
    match last {
        Some(last) => last.put::<DIRECTIONS>(job),
        None => Some(()),
    }
}

/// Skins the vertices of a job with a remap or a rest mesh.
///
/// - `CORRECTED`: as for [`plain`].
#[inline(always)]
fn changed<S: Simd, const CORRECTED: bool>(simd: S, job: &SkinJob<'_>) -> Option<()> {
    let (range, file) = (job.range(), File::new(&job.skin));
    let (palette, side) = (job.palette, side(job.palette));
    let remap = job.remap.and_then(|remap| remap.get(range.clone()));
    let (mut gathered, mut copies) = (Gathered::NONE, Copies::NONE);
    let mut lane = if job.remap.is_some() { 0 } else { range.start % EIGHT };
    let mut done = 0;
    while done < range.len() {
        let lanes = lane..EIGHT.min(lane + range.len() - done);
        let remapped = remap.and_then(|remap| remap.get(done..done + lanes.len()));
        let source = match remapped {
            Some(vertices) => copies.source(vertices),
            None => Source::Block(range.start + done),
        };
        let block = match source {
            Source::Block(vertex) => gathered.block(simd, job, &file, vertex)?,
            Source::Gather => gathered.gather(simd, job, &file, done, &lanes)?,
            Source::Copies => {
                copies.put(job, done, remapped?)?;
                done += lanes.len();
                continue;
            }
        };
        let posed = pose::<S, CORRECTED, 2>(simd, &block, palette, side)?;
        if let (Source::Block(vertex), Some(_)) = (source, remapped) {
            posed.copy(vertex, &mut copies);
            continue;
        }
        (lane, done) = (0, done + lanes.len());
        Posed { first: done - lanes.len(), lanes, ..posed }.put::<2>(job)?;
    }
    Some(())
}

/// Eight posed vertices, one register for each number.
struct Posed<S: Simd> {
    /// First vertex of the range that is in the block, and its lanes.
    first: usize,
    lanes: Range<usize>,
    positions: [f32x8<S>; 3],
    normals: Directions<S>,
    tangents: Directions<S>,
    /// Handedness of the tangents.
    hands: f32x8<S>,
}

/// Directions of any length, and their squared lengths with a sign for all.
#[derive(Clone, Copy)]
struct Directions<S: Simd> {
    v: [f32x8<S>; 3],
    /// Factor that makes the length 1.
    scale: f32x8<S>,
    /// Whether each has a direction.
    are_sound: bool,
}

impl<S: Simd> Directions<S> {
    /// - `length`: 1, or -1 to reverse the directions.
    #[inline(always)]
    fn new(v: [f32x8<S>; 3], length: f32) -> Self {
        let square = dot(v, v);
        let scale = f32x8::splat(square.simd, length) / square.sqrt();
        Self { v, scale, are_sound: are_normal(square) }
    }
}

impl<S: Simd> Posed<S> {
    /// Keeps the block of a skin vertex.
    #[inline(always)]
    fn copy(&self, vertex: usize, out: &mut Copies) {
        let first = out.keep(vertex);
        let own = first..first + EIGHT;
        let [x, y, z] = self.positions;
        out.positions[own.clone()].copy_from_slice(&arrays(rows([x, y, z, z])));
        let [x, y, z] = scaled(self.normals.v, self.normals.scale);
        out.normals[own.clone()].copy_from_slice(&arrays(rows([x, y, z, z])));
        let [x, y, z] = scaled(self.tangents.v, self.tangents.scale);
        out.tangents[own].copy_from_slice(&arrays(rows([x, y, z, self.hands])));
        out.are_sound[first / EIGHT] = self.normals.are_sound && self.tangents.are_sound;
    }

    /// Writes the vertices.
    #[inline(always)]
    fn put<const DIRECTIONS: usize>(&self, job: &SkinJob<'_>) -> Option<()> {
        let (i, lanes) = (self.first, &self.lanes);
        if let Some(out) = &job.positions {
            let [x, y, z] = self.positions;
            put::<S, 3>(out, i, lanes, rows([x, y, z, z]))?;
        }
        if let Some(out) = job.normals.as_ref().filter(|_| DIRECTIONS > 0) {
            let [x, y, z] = scaled(self.normals.v, self.normals.scale);
            put::<S, 3>(out, i, lanes, rows([x, y, z, z]))?;
        }
        if let Some(out) = job.tangents.as_ref().filter(|_| DIRECTIONS > 1) {
            let [x, y, z] = scaled(self.tangents.v, self.tangents.scale);
            put::<S, 4>(out, i, lanes, rows([x, y, z, self.hands]))?;
        }
        if !(self.normals.are_sound && self.tangents.are_sound) {
            // A normal or tangent without a direction, maybe in the padding of the last block.
            job.one_by_one(i..i + lanes.len())?;
        }
        Some(())
    }
}

/// Writes N numbers of some vertices, from the i-th vertex of the range on. `None` cannot happen after the checks.
#[inline(always)]
fn put<S: Simd, const N: usize>(
    out: &Output<'_>,
    i: usize,
    lanes: &Range<usize>,
    [a, b, c, d, e, f, g, h]: [f32x4<S>; EIGHT],
) -> Option<()> {
    let floats = out.floats.get(i * out.stride..)?;
    if N == 3
        && out.stride == 3
        && *lanes == (0..EIGHT)
        && let Some(floats) = floats.first_chunk::<{ 3 * EIGHT }>()
    {
        // One store for each vertex: the next vertex overwrites the fourth float.
        store(floats, 0, a);
        store(floats, 3, b);
        store(floats, 6, c);
        store(floats, 9, d);
        store(floats, 12, e);
        store(floats, 15, f);
        store(floats, 18, g);
        let [x, y, z, _] = h.to_array();
        floats[21].set(x);
        floats[22].set(y);
        floats[23].set(z);
        return Some(());
    }
    let rows = arrays([a, b, c, d, e, f, g, h]);
    // Chunks of 0 would panic.
    for (out, row) in floats.chunks(out.stride.max(1)).zip(rows.get(lanes.clone())?) {
        out.first_chunk::<N>()?.iter().zip(row).for_each(|(out, value)| out.set(*value));
    }
    Some(())
}

#[inline(always)]
fn arrays<S: Simd>([a, b, c, d, e, f, g, h]: [f32x4<S>; EIGHT]) -> [[f32; 4]; EIGHT] {
    let (a, b, c, d) = (a.to_array(), b.to_array(), c.to_array(), d.to_array());
    [a, b, c, d, e.to_array(), f.to_array(), g.to_array(), h.to_array()]
}

/// Writes a row.
#[inline(always)]
fn store<S: Simd, const N: usize>(floats: &[Cell<f32>; N], at: usize, row: f32x4<S>) {
    let [x, y, z, w] = row.to_array();
    floats[at].set(x);
    floats[at + 1].set(y);
    floats[at + 2].set(z);
    floats[at + 3].set(w);
}

/// Poses a block. `None` if an index is beyond the palette.
#[inline(always)]
fn pose<S: Simd, const CORRECTED: bool, const DIRECTIONS: usize>(
    simd: S,
    block: &Block<'_>,
    palette: &[Matrix3x4],
    side: f32,
) -> Option<Posed<S>> {
    let [x, y, z] = block.positions;
    let x = [read(simd, x), read(simd, y), read(simd, z)];
    let [a, b, c] = sums::<S, CORRECTED>(simd, block, palette, x)?;
    let linear = [a.linear, b.linear, c.linear];
    let positions = sum(along(linear, x), [a.shift, b.shift, c.shift]);
    let none = Directions { v: positions, scale: a.shift, are_sound: true };
    let mut posed =
        Posed { first: 0, lanes: 0..0, positions, normals: none, tangents: none, hands: a.shift };
    if DIRECTIONS == 0 {
        return Some(posed);
    }
    let [nx, ny, nz] = block.normals;
    let n = [read(simd, nx), read(simd, ny), read(simd, nz)];
    let tangent = match block.tangents {
        Some([x, y, z, _]) => [read(simd, x), read(simd, y), read(simd, z)],
        None => n,
    };
    let frame = match block.has_frame {
        true => Frame::of_tangent(n, tangent),
        false => Frame::of_normal(n, read(simd, block.up)),
    };
    let (g, h) = ([a.g, b.g, c.g], [a.h, b.h, c.h]);
    let turned = if CORRECTED {
        cross(sum(along(linear, frame.g), g), sum(along(linear, frame.h), h))
    } else {
        // By the cofactors of the columns.
        let [[xa, ya, za], [xb, yb, zb], [xc, yc, zc]] = linear;
        let (x, y, z) = ([xa, xb, xc], [ya, yb, yc], [za, zb, zc]);
        let ([xa, xb, xc], [ya, yb, yc]) = (cross(y, z), cross(z, x));
        let [za, zb, zc] = cross(x, y);
        along([[xa, ya, za], [xb, yb, zb], [xc, yc, zc]], n)
    };
    posed.normals = Directions::new(turned, side);
    if let Some([.., hands]) = block.tangents.filter(|_| DIRECTIONS > 1) {
        let mut turned = along(linear, tangent);
        if CORRECTED {
            turned = sum(turned, scaled(g, dot(tangent, frame.g)));
            turned = sum(turned, scaled(h, dot(tangent, frame.h)));
        }
        posed.tangents = Directions::new(turned, 1.0);
        posed.hands = read(simd, hands);
    }
    Some(posed)
}

/// Sums over the influences of eight vertices, for one coordinate.
struct Sums<S: Simd> {
    /// The coordinate under the first transform.
    first: f32x8<S>,
    /// Row of the blended transforms: three columns, and the shift.
    linear: [f32x8<S>; 3],
    shift: f32x8<S>,
    /// Correction of the frame.
    g: f32x8<S>,
    h: f32x8<S>,
}

impl<S: Simd> Sums<S> {
    /// Starts with the first influence.
    ///
    /// - `row`: columns of the row of the transforms.
    /// - `x`: rest positions.
    #[inline(always)]
    fn new([p, q, r, shift]: [f32x8<S>; 4], weight: f32x8<S>, x: [f32x8<S>; 3]) -> Self {
        let zero = f32x8::splat(weight.simd, 0.0);
        Self {
            first: dot([p, q, r], x) + shift,
            linear: [zero + p * weight, zero + q * weight, zero + r * weight],
            shift: zero + shift * weight,
            g: zero,
            h: zero,
        }
    }

    /// Adds an influence.
    ///
    /// - `pair`: coefficients g and h, if the skin has them.
    #[inline(always)]
    fn add(
        &mut self,
        [p, q, r, shift]: [f32x8<S>; 4],
        weight: f32x8<S>,
        x: [f32x8<S>; 3],
        pair: Option<[f32x8<S>; 2]>,
    ) {
        let [sum_p, sum_q, sum_r] = self.linear;
        self.linear = [sum_p + p * weight, sum_q + q * weight, sum_r + r * weight];
        self.shift += shift * weight;
        if let Some([g, h]) = pair {
            let apart = (dot([p, q, r], x) + shift) - self.first;
            self.g += g * apart;
            self.h += h * apart;
        }
    }
}

/// Sums over the influences of a block. `None` if an index is beyond the palette.
#[inline(always)]
fn sums<S: Simd, const CORRECTED: bool>(
    simd: S,
    block: &Block<'_>,
    palette: &[Matrix3x4],
    x: [f32x8<S>; 3],
) -> Option<[Sums<S>; 3]> {
    let (indices, more_indices) = block.indices.split_first()?;
    let (weight, weights) = block.weights.split_first()?;
    let weight = read(simd, weight);
    let mut sums = match Transforms::of(palette, indices)? {
        Transforms::One(rows) => start(simd, &One(rows), weight, x),
        Transforms::Eight(rows) => start(simd, &Each(rows), weight, x),
    };
    let others = block.influence_len::<CORRECTED>() - 1;
    let mut coefficients = block.coefficients.iter();
    for (indices, weight) in more_indices.iter().zip(weights).take(others) {
        let weight = read(simd, weight);
        let pair = if CORRECTED { Some(halves(simd, coefficients.next()?)) } else { None };
        match Transforms::of(palette, indices)? {
            Transforms::One(rows) => add(simd, &mut sums, &One(rows), weight, x, pair),
            Transforms::Eight(rows) => add(simd, &mut sums, &Each(rows), weight, x, pair),
        }
    }
    Some(sums)
}

/// Starts the sums of each coordinate.
#[inline(always)]
fn start<S: Simd>(simd: S, rows: &impl Rows, weight: f32x8<S>, x: [f32x8<S>; 3]) -> [Sums<S>; 3] {
    [
        Sums::new(rows.row::<S, 0>(simd), weight, x),
        Sums::new(rows.row::<S, 1>(simd), weight, x),
        Sums::new(rows.row::<S, 2>(simd), weight, x),
    ]
}

/// Adds an influence to the sums of each coordinate.
#[inline(always)]
fn add<S: Simd>(
    simd: S,
    [a, b, c]: &mut [Sums<S>; 3],
    rows: &impl Rows,
    weight: f32x8<S>,
    x: [f32x8<S>; 3],
    pair: Option<[f32x8<S>; 2]>,
) {
    a.add(rows.row::<S, 0>(simd), weight, x, pair);
    b.add(rows.row::<S, 1>(simd), weight, x, pair);
    c.add(rows.row::<S, 2>(simd), weight, x, pair);
}

/// Transforms of eight vertices.
enum Transforms<'a> {
    /// One for all of them.
    One(&'a Matrix3x4),
    Eight([&'a Matrix3x4; EIGHT]),
}

impl<'a> Transforms<'a> {
    /// Looks up transforms. `None` if an index is beyond the palette.
    #[inline(always)]
    fn of(palette: &'a [Matrix3x4], indices: &[[u8; 2]; EIGHT]) -> Option<Self> {
        let [a, b, c, d, e, f, g, h] = *indices;
        let (first, second) = (one(palette, a)?, [e, f, g, h]);
        if *indices == [a; EIGHT] {
            return Some(Self::One(first));
        }
        let (b, c, d) = (one(palette, b)?, one(palette, c)?, one(palette, d)?);
        let [e, f, g, h] = second;
        let (e, f, g, h) = (one(palette, e)?, one(palette, f)?, one(palette, g)?, one(palette, h)?);
        Some(Self::Eight([first, b, c, d, e, f, g, h]))
    }
}

/// Looks up a transform.
#[inline(always)]
fn one(palette: &[Matrix3x4], index: [u8; 2]) -> Option<&Matrix3x4> {
    palette.get(usize::from(u16::from_le_bytes(index)))
}

/// Rows of the transforms of eight vertices.
trait Rows {
    /// Returns the columns of a row.
    fn row<S: Simd, const ROW: usize>(&self, simd: S) -> [f32x8<S>; 4];
}

struct One<'a>(&'a Matrix3x4);

struct Each<'a>([&'a Matrix3x4; EIGHT]);

impl Rows for One<'_> {
    #[inline(always)]
    fn row<S: Simd, const ROW: usize>(&self, simd: S) -> [f32x8<S>; 4] {
        let [p, q, r, shift] = self.0[ROW];
        let (p, q) = (f32x8::splat(simd, p), f32x8::splat(simd, q));
        [p, q, f32x8::splat(simd, r), f32x8::splat(simd, shift)]
    }
}

impl Rows for Each<'_> {
    #[inline(always)]
    fn row<S: Simd, const ROW: usize>(&self, simd: S) -> [f32x8<S>; 4] {
        let [a, b, c, d, e, f, g, h] = self.0;
        let (a, b, c, d) = (&a[ROW], &b[ROW], &c[ROW], &d[ROW]);
        columns(simd, [a, b, c, d, &e[ROW], &f[ROW], &g[ROW], &h[ROW]])
    }
}

/// Returns a matrix of three rows times a vector.
#[inline(always)]
fn along<S: Simd>([a, b, c]: [[f32x8<S>; 3]; 3], v: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [dot(a, v), dot(b, v), dot(c, v)]
}

#[inline(always)]
fn sum<S: Simd>([a, b, c]: [f32x8<S>; 3], [x, y, z]: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a + x, b + y, c + z]
}

#[inline(always)]
fn scaled<S: Simd>([x, y, z]: [f32x8<S>; 3], by: f32x8<S>) -> [f32x8<S>; 3] {
    [x * by, y * by, z * by]
}
