//! Stage shapes: from weights to the rest mesh of a skin job (METHOD §5).

use super::super::counts::BLOCK;
use super::super::normals::{Frame, unit};
use super::super::output::{Output, Outputs, check_range};
use super::super::view::{Skin, of_vertex};
use super::blocks::Blocks;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::floats;
use core::ops::Range;

/// Job that shapes a range of vertices at rest.
///
/// The position of a vertex is its rest position plus `sum z_s u_s`, over the shapes whose weight is not 0, in the
/// file's order. A [`super::super::SkinJob`] takes the output as its rest mesh.
#[derive(Clone, Debug)]
#[must_use = "a job does nothing until it runs"]
pub struct ShapesJob<'a> {
    skin: Skin<'a>,
    weights: &'a [f32],
    vertices: Range<usize>,
    positions: Option<Output<'a>>,
    normals: Option<Output<'a>>,
    tangents: Option<Output<'a>>,
}

/// Sums of the weighted deltas and slopes over the shapes, for one block of vertices.
struct Sums {
    deltas: [[f32; 3]; BLOCK],
    slopes: [[f32; 2]; BLOCK],
}

impl<'a> ShapesJob<'a> {
    /// Makes a job of all vertices, without outputs.
    ///
    /// - `weights`: [`Skin::shape_len`] weights z.
    pub fn new(skin: Skin<'a>, weights: &'a [f32]) -> Self {
        let (vertices, positions, normals, tangents) = (0..skin.vertex_len(), None, None, None);
        Self { skin, weights, vertices, positions, normals, tangents }
    }

    /// Sets the range of vertices. Jobs of different ranges can run at the same time. If every range starts at a
    /// multiple of 64, no block is summed twice.
    pub fn vertices(self, vertices: Range<usize>) -> Self {
        Self { vertices, ..self }
    }

    /// Writes positions: 3 floats, in model space.
    pub fn positions(self, positions: impl Into<Option<Output<'a>>>) -> Self {
        Self { positions: positions.into(), ..self }
    }

    /// Writes normals: 3 floats of length 1, tilted by the sums of the shapes' slopes.
    ///
    /// With one shape at a weight of 1 and all others at 0, these are the normals of the shaped surface. If no
    /// direction is left, the result is the file's normal, which may be 0.
    #[cfg(feature = "normals")]
    pub fn normals(self, normals: impl Into<Option<Output<'a>>>) -> Self {
        Self { normals: normals.into(), ..self }
    }

    /// Writes tangents: 3 floats of length 1, tilted by the sums of the slopes, then the file's handedness.
    #[cfg(feature = "normals")]
    pub fn tangents(self, tangents: impl Into<Option<Output<'a>>>) -> Self {
        Self { tangents: tangents.into(), ..self }
    }

    /// Runs the job.
    ///
    /// # Errors
    /// - [`CallErrorKind::NoOutput`]: the job has no output.
    /// - [`CallErrorKind::Length`]: `weights` has another length.
    /// - [`CallErrorKind::NonFinite`]: a weight is not finite.
    /// - [`CallErrorKind::OutOfRange`]: `vertices` is not inside the skin.
    /// - [`CallErrorKind::NoAttribute`]: the job has an output of tangents, but the skin has no tangents.
    /// - [`CallErrorKind::Stride`]: a stride is shorter than its attribute.
    /// - [`CallErrorKind::TooShort`]: an output is too short for its attribute.
    /// - [`CallErrorKind::Overlap`]: two outputs share a float.
    pub fn run(&self) -> Result<(), CallError> {
        self.check()?;
        let Range { start, end } = self.vertices;
        let blocks = Blocks::of(&self.skin);
        let tilts = self.normals.is_some() || self.tangents.is_some();
        let mut sums = Sums::NONE;
        for block in start / BLOCK..end.div_ceil(BLOCK) {
            let first = block * BLOCK;
            sums.add(&blocks, block, self.weights, tilts);
            let own = start.max(first)..end.min(first + BLOCK);
            self.write(own, &sums);
        }
        Ok(())
    }

    /// Checks every argument. The errors are those of [`Self::run`].
    fn check(&self) -> Result<(), CallError> {
        let outputs = [&self.positions, &self.normals, &self.tangents].map(Option::as_ref);
        let outputs = Outputs::new(outputs)?;
        self.skin.check_weights(self.weights)?;
        check_range(&self.vertices, self.skin.vertex_len())?;
        if self.tangents.is_some() && !self.skin.has_tangents() {
            return Err(CallError::new(CallErrorKind::NoAttribute, Argument::Tangents));
        }
        outputs.check(self.vertices.len())
    }

    /// Writes vertices of one block.
    ///
    /// `None` only if the bytes of the file have changed since loading.
    fn write(&self, vertices: Range<usize>, sums: &Sums) -> Option<()> {
        let skin = &self.skin;
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        for vertex in vertices {
            let i = vertex - self.vertices.start;
            if let Some(out) = &self.positions {
                let ([x, y, z], [u, v, w]) =
                    (of_vertex(positions, vertex)?, *sums.deltas.get(vertex % BLOCK)?);
                out.put(i, [x + u, y + v, z + w])?;
            }
            if self.normals.is_none() && self.tangents.is_none() {
                continue;
            }
            let [a, c] = *sums.slopes.get(vertex % BLOCK)?;
            let n = of_vertex(normals, vertex)?;
            let tangent = of_vertex(tangents, vertex);
            if let Some(out) = &self.normals {
                let Frame { g, h } = match tangent {
                    Some([x, y, z, _]) => Frame::of_tangent(n, [x, y, z]),
                    None => Frame::of_normal(n, n[2]),
                };
                let tilted = [
                    (n[0] - a * g[0]) - c * h[0],
                    (n[1] - a * g[1]) - c * h[1],
                    (n[2] - a * g[2]) - c * h[2],
                ];
                out.put(i, unit(tilted, 1.0).unwrap_or(n))?;
            }
            if let Some((out, [x, y, z, hand])) = self.tangents.as_ref().zip(tangent) {
                let tilted = [x + a * n[0], y + a * n[1], z + a * n[2]];
                let [x, y, z] = unit(tilted, 1.0).unwrap_or([x, y, z]);
                out.put(i, [x, y, z, hand])?;
            }
        }
        Some(())
    }
}

impl Sums {
    const NONE: Self = Self { deltas: [[0.0; 3]; BLOCK], slopes: [[0.0; 2]; BLOCK] };

    /// Computes the sums of one block.
    ///
    /// - `tilts`: whether slopes are needed.
    ///
    /// `None` only if the bytes of the file have changed since loading.
    #[cfg_attr(target_os = "none", inline(never))]
    fn add(
        &mut self,
        blocks: &Blocks<'_>,
        block: usize,
        weights: &[f32],
        tilts: bool,
    ) -> Option<()> {
        self.deltas.as_flattened_mut().fill(0.0);
        self.slopes.as_flattened_mut().fill(0.0);
        for entry in blocks.entries_of(block) {
            let weight = *weights.get(entry.shape)?;
            if weight == 0.0 {
                continue;
            }
            let [step, slope_step, ..] = floats(blocks.rows.get(entry.shape)?);
            blocks.deltas.add_entry(weight * step, entry, &mut self.deltas)?;
            if tilts {
                blocks.slopes.add_entry(weight * slope_step, entry, &mut self.slopes)?;
            }
        }
        Some(())
    }
}
