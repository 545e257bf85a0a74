//! Posed blocks. A remap copies vertices from them.

use super::super::counts::EIGHT;
use super::super::job::SkinJob;

/// Where some vertices of a job come from.
#[derive(Clone, Copy)]
pub(super) enum Source {
    /// The block of a skin vertex, which has to be posed.
    Block(usize),
    /// Posed blocks.
    Copies,
    /// Blocks that are not neighbours.
    Gather,
}

/// Rows of an attribute of two blocks: vertex v has row v % 16.
type Rows = [[f32; 4]; 2 * EIGHT];

/// Two posed blocks, one with an even number and one with an odd number.
pub(super) struct Copies {
    /// Number of each block; `None` for no block yet.
    blocks: [Option<usize>; 2],
    pub(super) positions: Rows,
    pub(super) normals: Rows,
    pub(super) tangents: Rows,
    /// Whether all normals and tangents of each block have a direction.
    pub(super) are_sound: [bool; 2],
}

impl Copies {
    pub(super) const NONE: Self = {
        const ROWS: Rows = [[0.0; 4]; 2 * EIGHT];
        let (blocks, are_sound) = ([None; 2], [true; 2]);
        Self { blocks, positions: ROWS, normals: ROWS, tangents: ROWS, are_sound }
    };

    /// Returns where skin vertices come from.
    #[inline(always)]
    pub(super) fn source(&self, vertices: &[u32]) -> Source {
        let (mut least, mut most) = (u32::MAX, 0);
        for vertex in vertices {
            (least, most) = (least.min(*vertex), most.max(*vertex));
        }
        let (first, second) = (least as usize / EIGHT, most as usize / EIGHT);
        match [first, second].into_iter().find(|block| self.blocks[block % 2] != Some(*block)) {
            _ if second - first > 1 => Source::Gather,
            Some(block) => Source::Block(block * EIGHT),
            None => Source::Copies,
        }
    }

    /// Marks the block of a skin vertex as posed, and returns the number of its first row.
    #[inline(always)]
    pub(super) fn keep(&mut self, vertex: usize) -> usize {
        let block = vertex / EIGHT;
        self.blocks[block % 2] = Some(block);
        block % 2 * EIGHT
    }

    /// Writes skin vertices to the outputs of a job, from its i-th vertex on.
    #[inline(always)]
    pub(super) fn put(&self, job: &SkinJob<'_>, i: usize, vertices: &[u32]) -> Option<()> {
        for (i, vertex) in (i..).zip(vertices) {
            let row = *vertex as usize % (2 * EIGHT);
            if let Some(out) = &job.positions {
                let [x, y, z, _] = self.positions[row];
                out.put(i, [x, y, z])?;
            }
            if let Some(out) = &job.normals {
                let [x, y, z, _] = self.normals[row];
                out.put(i, [x, y, z])?;
            }
            if let Some(out) = &job.tangents {
                out.put(i, self.tangents[row])?;
            }
        }
        if self.are_sound != [true; 2] {
            job.one_by_one(i..i + vertices.len())?;
        }
        Some(())
    }
}
