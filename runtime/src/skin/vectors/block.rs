//! Blocks of eight vertices, of the file or gathered from it.

use super::super::counts::EIGHT;
use super::super::job::SkinJob;
use super::super::view::{Row, Skin, rows_of};
use crate::linear::Le;
use bytemuck::cast;
use core::ops::Range;
use fearless_simd::{Simd, f32x8, prelude::*, u16x8};

/// Most influences of a vertex.
pub(super) const MOST: usize = 16;

/// Rows of eight vertices.
#[derive(Clone, Copy)]
pub(super) struct Block<'b> {
    pub(super) positions: &'b [Row; 3],
    pub(super) normals: &'b [Row; 3],
    /// z of the file's normals.
    pub(super) up: &'b Row,
    /// `None` if neither the skin nor the caller has tangents.
    pub(super) tangents: Option<&'b [Row; 4]>,
    /// Whether the frames of the coefficients are made of the tangents: so if the skin has tangents.
    pub(super) has_frame: bool,
    /// K rows.
    pub(super) indices: &'b [[[u8; 2]; EIGHT]],
    /// K rows.
    pub(super) weights: &'b [Row],
    /// K - 1 rows, or none without tangent coefficients.
    pub(super) coefficients: &'b [Row],
}

/// The attributes of a skin in its file.
pub(super) struct File<'b> {
    positions: &'b [[Row; 3]],
    normals: &'b [[Row; 3]],
    tangents: &'b [[Row; 4]],
    indices: &'b [[[u8; 2]; EIGHT]],
    weights: &'b [Row],
    coefficients: &'b [Row],
    /// K.
    len: usize,
    /// K - 1, or 0 without tangent coefficients.
    coefficient_len: usize,
}

impl<'b> File<'b> {
    pub(super) fn new(skin: &Skin<'b>) -> Self {
        let len = skin.influence_len();
        Self {
            positions: skin.positions(),
            normals: skin.normals(),
            tangents: skin.tangents(),
            indices: skin.indices(),
            weights: skin.weights(),
            coefficients: skin.coefficients(),
            len,
            coefficient_len: if skin.has_coefficients() { len - 1 } else { 0 },
        }
    }

    /// Returns the block of a skin vertex. `None` if the vertex is beyond the mesh.
    #[inline(always)]
    pub(super) fn block(&self, vertex: usize) -> Option<Block<'b>> {
        let normals = self.normals.get(vertex / EIGHT)?;
        Some(Block {
            positions: self.positions.get(vertex / EIGHT)?,
            normals,
            up: &normals[2],
            tangents: self.tangents.get(vertex / EIGHT),
            has_frame: !self.tangents.is_empty(),
            indices: rows_of(self.indices, self.len, vertex)?,
            weights: rows_of(self.weights, self.len, vertex)?,
            coefficients: rows_of(self.coefficients, self.coefficient_len, vertex)?,
        })
    }
}

impl Block<'_> {
    /// Returns the influences in use: the last ones whose weights and coefficients are 0 in all lanes are left out.
    ///
    /// - `CORRECTED`: whether coefficients count.
    #[inline(always)]
    pub(super) fn influence_len<const CORRECTED: bool>(&self) -> usize {
        const NONE: Row = [[0; 4]; EIGHT];
        let mut len = self.weights.len();
        while len > 1
            && self.weights.get(len - 1) == Some(&NONE)
            && (!CORRECTED || self.coefficients.get(len - 2) == Some(&NONE))
        {
            len -= 1;
        }
        len
    }
}

/// Rows of vertices that do not stand side by side in the file.
pub(super) struct Gathered {
    positions: [Row; 3],
    normals: [Row; 3],
    up: Row,
    tangents: [Row; 4],
    indices: [[[u8; 2]; EIGHT]; MOST],
    weights: [Row; MOST],
    coefficients: [Row; MOST],
}

impl Gathered {
    pub(super) const NONE: Self = {
        const ROW: Row = [[0; 4]; EIGHT];
        Self {
            positions: [ROW; 3],
            normals: [ROW; 3],
            up: ROW,
            tangents: [ROW; 4],
            indices: [[[0; 2]; EIGHT]; MOST],
            weights: [ROW; MOST],
            coefficients: [ROW; MOST],
        }
    };

    /// Returns the block of a skin vertex, with the attributes of the caller's rest mesh. `None` if the vertex is beyond
    /// the mesh.
    #[inline(always)]
    pub(super) fn block<'b, S: Simd>(
        &'b mut self,
        simd: S,
        job: &SkinJob<'b>,
        file: &File<'b>,
        vertex: usize,
    ) -> Option<Block<'b>> {
        let rest = &job.rest;
        let mut block = file.block(vertex)?;
        if rest.positions.is_none() && rest.normals.is_none() && rest.tangents.is_none() {
            return Some(block);
        }
        let (first, last) = (vertex / EIGHT * EIGHT, job.skin.vertex_len() - 1);
        let mut all = [first; EIGHT];
        for (lane, vertex) in all.iter_mut().enumerate() {
            *vertex = last.min(first + lane);
        }
        if rest.positions.is_some() {
            put(simd, &mut self.positions, rest.positions, &[], &all)?;
            block.positions = &self.positions;
        }
        if rest.normals.is_some() {
            put(simd, &mut self.normals, rest.normals, &[], &all)?;
            block.normals = &self.normals;
        }
        if rest.tangents.is_some() {
            put(simd, &mut self.tangents, rest.tangents, &[], &all)?;
            block.tangents = Some(&self.tangents);
        }
        Some(block)
    }

    /// Reads vertices of a job, from the i-th of its range on, into lanes. Other lanes repeat one of them.
    ///
    /// Rows are written whole: a register that is read right after writes of its parts waits for them.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(
        &mut self,
        simd: S,
        job: &SkinJob<'_>,
        file: &File<'_>,
        i: usize,
        lanes: &Range<usize>,
    ) -> Option<Block<'_>> {
        let mut all = [0; EIGHT];
        for (lane, vertex) in all.iter_mut().enumerate() {
            *vertex = job.vertex(i + lane.clamp(lanes.start, lanes.end - 1) - lanes.start)?;
        }
        let rest = &job.rest;
        put(simd, &mut self.positions, rest.positions, file.positions, &all)?;
        put(simd, &mut self.normals, rest.normals, file.normals, &all)?;
        if rest.normals.is_some() {
            let mut normals = self.normals;
            put(simd, &mut normals, None, file.normals, &all)?;
            self.up = normals[2];
        } else {
            self.up = self.normals[2];
        }
        if rest.tangents.is_some() || !file.tangents.is_empty() {
            put(simd, &mut self.tangents, rest.tangents, file.tangents, &all)?;
        }
        let indices = rows(file.indices, file.len, &all)?;
        for (k, out) in self.indices.iter_mut().enumerate().take(file.len) {
            let [a, b, c, d, e, f, g, h] = lanes_of(&indices, k, &all)?;
            let all = u16x8::load_array(
                simd,
                [cast(a), cast(b), cast(c), cast(d), cast(e), cast(f), cast(g), cast(h)],
            );
            *out = cast(all.to_array());
        }
        let weights = rows(file.weights, file.len, &all)?;
        for (k, out) in self.weights.iter_mut().enumerate().take(file.len) {
            *out = row(simd, lanes_of(&weights, k, &all)?);
        }
        let coefficients = rows(file.coefficients, file.coefficient_len, &all)?;
        for (k, out) in self.coefficients.iter_mut().enumerate().take(file.coefficient_len) {
            *out = row(simd, lanes_of(&coefficients, k, &all)?);
        }
        let has_frame = !file.tangents.is_empty();
        Some(Block {
            positions: &self.positions,
            normals: &self.normals,
            up: &self.up,
            tangents: Some(&self.tangents).filter(|_| has_frame || rest.tangents.is_some()),
            has_frame,
            indices: self.indices.get(..file.len)?,
            weights: self.weights.get(..file.len)?,
            coefficients: self.coefficients.get(..file.coefficient_len)?,
        })
    }
}

/// Reads an attribute of eight vertices: from the caller's rest mesh, or from the file.
#[inline(always)]
fn put<S: Simd, const N: usize>(
    simd: S,
    out: &mut [Row; N],
    given: Option<&[[f32; N]]>,
    file: &[[Row; N]],
    &[a, b, c, d, e, f, g, h]: &[usize; EIGHT],
) -> Option<()> {
    if let Some(given) = given {
        let (a, b, c, d) = (given.get(a)?, given.get(b)?, given.get(c)?, given.get(d)?);
        let (e, f, g, h) = (given.get(e)?, given.get(f)?, given.get(g)?, given.get(h)?);
        for (n, out) in out.iter_mut().enumerate() {
            let own = [a[n], b[n], c[n], d[n], e[n], f[n], g[n], h[n]];
            *out = cast(f32x8::load_array(simd, own).to_array());
        }
        return Some(());
    }
    let block = |vertex: usize| file.get(vertex / EIGHT);
    let blocks = [block(a)?, block(b)?, block(c)?, block(d)?];
    let more = [block(e)?, block(f)?, block(g)?, block(h)?];
    for (n, out) in out.iter_mut().enumerate() {
        let [i, j, k, l] = [
            blocks[0][n][a % EIGHT],
            blocks[1][n][b % EIGHT],
            blocks[2][n][c % EIGHT],
            blocks[3][n][d % EIGHT],
        ];
        let [m, o, p, q] = [
            more[0][n][e % EIGHT],
            more[1][n][f % EIGHT],
            more[2][n][g % EIGHT],
            more[3][n][h % EIGHT],
        ];
        *out = row(simd, [i, j, k, l, m, o, p, q]);
    }
    Some(())
}

/// Returns the rows of the blocks of eight vertices.
#[inline(always)]
fn rows<'b, T>(
    all: &'b [T],
    len: usize,
    &[a, b, c, d, e, f, g, h]: &[usize; EIGHT],
) -> Option<[&'b [T]; EIGHT]> {
    let (a, b, c, d) = (
        rows_of(all, len, a)?,
        rows_of(all, len, b)?,
        rows_of(all, len, c)?,
        rows_of(all, len, d)?,
    );
    Some([
        a,
        b,
        c,
        d,
        rows_of(all, len, e)?,
        rows_of(all, len, f)?,
        rows_of(all, len, g)?,
        rows_of(all, len, h)?,
    ])
}

/// Returns the k-th number of eight vertices.
#[inline(always)]
fn lanes_of<T: Copy>(
    [a, b, c, d, e, f, g, h]: &[&[[T; EIGHT]]; EIGHT],
    k: usize,
    all: &[usize; EIGHT],
) -> Option<[T; EIGHT]> {
    let (a, b, c, d) = (a.get(k)?, b.get(k)?, c.get(k)?, d.get(k)?);
    let (e, f, g, h) = (e.get(k)?, f.get(k)?, g.get(k)?, h.get(k)?);
    Some([
        a[all[0] % EIGHT],
        b[all[1] % EIGHT],
        c[all[2] % EIGHT],
        d[all[3] % EIGHT],
        e[all[4] % EIGHT],
        f[all[5] % EIGHT],
        g[all[6] % EIGHT],
        h[all[7] % EIGHT],
    ])
}

/// Makes a row by way of a register.
#[inline(always)]
fn row<S: Simd>(simd: S, [a, b, c, d, e, f, g, h]: [Le; EIGHT]) -> Row {
    let row = [cast(a), cast(b), cast(c), cast(d), cast(e), cast(f), cast(g), cast(h)];
    cast(f32x8::load_array(simd, row).to_array())
}
