//! Blocks of eight vertices, of the file or gathered from it.

use super::super::job::SkinJob;
use super::super::view::{EIGHT, Row, of_vertex, rows_of};
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

impl<'b> Block<'b> {
    /// Returns the block of a skin vertex. `None` if the vertex is beyond the mesh.
    #[inline(always)]
    pub(super) fn of_file(job: &SkinJob<'b>, vertex: usize) -> Option<Self> {
        let (skin, at) = (job.skin, vertex / EIGHT);
        let k = skin.influence_len();
        let normals = skin.normals().get(at)?;
        Some(Self {
            positions: skin.positions().get(at)?,
            normals,
            up: &normals[2],
            tangents: skin.tangents().get(at),
            has_frame: skin.has_tangents(),
            indices: rows_of(skin.indices(), k, vertex)?,
            weights: rows_of(skin.weights(), k, vertex)?,
            coefficients: rows_of(skin.coefficients(), k - 1, vertex).unwrap_or_default(),
        })
    }

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
        i: usize,
        lanes: &Range<usize>,
    ) -> Option<Block<'_>> {
        let SkinJob { skin, rest, .. } = job;
        let (k, others) = (skin.influence_len(), skin.influence_len() - 1);
        for lane in 0..EIGHT {
            let own = lane.clamp(lanes.start, lanes.end - 1) - lanes.start;
            let vertex = job.vertex(i + own)?;
            put(&mut self.positions, lane, rest.positions, skin.positions(), vertex)?;
            put(&mut self.normals, lane, rest.normals, skin.normals(), vertex)?;
            self.up[lane] = skin.normals().get(vertex / EIGHT)?[2][vertex % EIGHT];
            // `None` without tangents.
            let _ = put(&mut self.tangents, lane, rest.tangents, skin.tangents(), vertex);
            copy(&mut self.indices, rows_of(skin.indices(), k, vertex)?, lane, vertex);
            copy(&mut self.weights, rows_of(skin.weights(), k, vertex)?, lane, vertex);
            let coefficients = rows_of(skin.coefficients(), others, vertex).unwrap_or_default();
            copy(&mut self.coefficients, coefficients, lane, vertex);
        }
        let has_tangents = skin.has_tangents() || rest.tangents.is_some();
        let coefficient_len = if skin.has_coefficients() { others } else { 0 };
        Some(Block {
            positions: &self.positions,
            normals: &self.normals,
            up: &self.up,
            tangents: Some(&self.tangents).filter(|_| has_tangents),
            has_frame: skin.has_tangents(),
            indices: self.indices.get(..k)?,
            weights: self.weights.get(..k)?,
            coefficients: self.coefficients.get(..coefficient_len)?,
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
