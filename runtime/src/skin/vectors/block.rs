//! Blocks of eight vertices, of the file or gathered from it.

use super::super::job::SkinJob;
use super::super::view::{EIGHT, Row, Skin, of_vertex, rows_of};
use core::ops::Range;

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

    /// Reads vertices of a job, from the i-th of its range on, into lanes. Other lanes repeat one of them.
    #[inline(always)]
    pub(super) fn gather(
        &mut self,
        job: &SkinJob<'_>,
        file: &File<'_>,
        i: usize,
        lanes: &Range<usize>,
    ) -> Option<Block<'_>> {
        let rest = &job.rest;
        for lane in 0..EIGHT {
            let own = lane.clamp(lanes.start, lanes.end - 1) - lanes.start;
            let vertex = job.vertex(i + own)?;
            put(&mut self.positions, lane, rest.positions, file.positions, vertex)?;
            put(&mut self.normals, lane, rest.normals, file.normals, vertex)?;
            self.up[lane] = file.normals.get(vertex / EIGHT)?[2][vertex % EIGHT];
            // `None` without tangents.
            let _ = put(&mut self.tangents, lane, rest.tangents, file.tangents, vertex);
            copy(&mut self.indices, rows_of(file.indices, file.len, vertex)?, lane, vertex);
            copy(&mut self.weights, rows_of(file.weights, file.len, vertex)?, lane, vertex);
            let coefficients = rows_of(file.coefficients, file.coefficient_len, vertex)?;
            copy(&mut self.coefficients, coefficients, lane, vertex);
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

/// Copies an attribute of a vertex into a lane: of the caller's rest mesh, or of the file.
#[inline(always)]
fn put<const N: usize>(
    rows: &mut [Row; N],
    lane: usize,
    given: Option<&[[f32; N]]>,
    file: &[[Row; N]],
    vertex: usize,
) -> Option<()> {
    let numbers = match given {
        Some(given) => *given.get(vertex)?,
        None => of_vertex(file, vertex)?,
    };
    for (row, number) in rows.iter_mut().zip(numbers) {
        row[lane % EIGHT] = number.to_le_bytes();
    }
    Some(())
}

/// Copies the numbers of a vertex into a lane.
#[inline(always)]
fn copy<T: Copy>(out: &mut [[T; EIGHT]], rows: &[[T; EIGHT]], lane: usize, vertex: usize) {
    for (out, row) in out.iter_mut().zip(rows) {
        out[lane % EIGHT] = row[vertex % EIGHT];
    }
}
