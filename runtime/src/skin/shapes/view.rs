//! Shapes of a skin: accessors, and the box around a shaped and posed skin.

use super::super::bounds::Bounds;
use super::super::counts::{BLOCK, RULES, ShapeErrors, place};
use super::super::view::Skin;
use super::blocks::{Blocks, SHAPES};
use crate::error::{Argument, CallError};
use crate::format::rule::Rule;
use crate::format::{Element, SectionKind};
use crate::linear::{Le, Matrix3x4, floats};
use crate::numeric::{greater, lesser};

const ERRORS: usize = Rule::place(&RULES, SectionKind::ShapeErrors);

impl<'a> Skin<'a> {
    /// Returns the element type of the deltas and slopes: f32, f16 or i8.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn shape_element(&self) -> Element {
        Blocks::of(self).deltas.element
    }

    /// Returns the offset of a vertex by a shape at a weight of 1; 0 if the shape does not move the vertex.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn shape_delta(&self, shape: usize, vertex: usize) -> Option<[f32; 3]> {
        self.check_shape(shape, vertex)?;
        let blocks = Blocks::of(self);
        let delta = |entry| blocks.delta(entry, vertex);
        Some(blocks.entry(vertex / BLOCK, shape).and_then(delta).unwrap_or_default())
    }

    /// Returns the slopes of the surface at a vertex by a shape at a weight of 1.
    ///
    /// The slopes are 0 if the shape does not move the vertex. A slope is the rise of the surface along one of the two directions of the vertex's frame at rest.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn shape_slopes(&self, shape: usize, vertex: usize) -> Option<[f32; 2]> {
        self.check_shape(shape, vertex)?;
        let blocks = Blocks::of(self);
        let slopes = |entry| blocks.slopes(entry, vertex);
        Some(blocks.entry(vertex / BLOCK, shape).and_then(slopes).unwrap_or_default())
    }

    /// Lists the shapes that move a vertex, with the offset at a weight of 1. Lists nothing beyond the mesh.
    pub fn deltas_of(&self, vertex: usize) -> impl Iterator<Item = (usize, [f32; 3])> + use<'a> {
        let blocks = Blocks::of(self);
        blocks
            .entries_of(vertex / BLOCK)
            .filter_map(move |entry| Some((entry.shape, blocks.delta(entry, vertex)?)))
    }

    /// Returns the box around 0 and the offsets of all vertices by a shape at a weight of 1.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn shape_box(&self, shape: usize) -> Option<Bounds> {
        let row: &[Le; 8] = self.0.entry(SHAPES, self.shape_len(), shape)?;
        Bounds::from_corners(row.last_chunk()?)
    }

    /// Returns the measured errors of the shapes; `None` if the file has none.
    pub fn shape_errors(&self) -> Option<ShapeErrors> {
        let figures = self.0.entry(ERRORS, 1, 0)?;
        Some(ShapeErrors::from_figures(floats(figures)))
    }

    /// Computes a box around every vertex of the shaped and posed skin; `None` if there are no vertices.
    ///
    /// The box is as for [`Skin::bounds`], with each rest box widened by the offsets of the shapes.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `weights`: [`Skin::shape_len`] weights z.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `palette` or `weights` has another length.
    /// - [`crate::CallErrorKind::NonFinite`]: a weight is not finite.
    pub fn shaped_bounds(
        &self,
        palette: &[Matrix3x4],
        weights: &[f32],
    ) -> Result<Option<Bounds>, CallError> {
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        self.check_weights(weights)?;
        let offsets = self.shape_offsets(weights);
        Ok(self.posed_bounds(palette, |rest| rest.add(&offsets)))
    }

    /// Checks the number of weights, [`Skin::shape_len`], and that all weights are finite.
    pub(crate) fn check_weights(&self, weights: &[f32]) -> Result<(), CallError> {
        Argument::Weights.check_len(self.shape_len(), weights.len())?;
        Argument::Weights.check_finite(weights.iter().position(|weight| !weight.is_finite()))
    }

    /// Computes the box around 0 and the offsets of all vertices by the weighted shapes.
    fn shape_offsets(&self, weights: &[f32]) -> Bounds {
        let (mut sum, mut magnitude) = (Bounds::of([0.0; 3]), [0.0; 3]);
        for (row, weight) in Blocks::of(self).rows.iter().zip(weights) {
            let Some(own) = row.last_chunk().and_then(Bounds::from_corners) else { continue };
            let sides = sum.min.iter_mut().zip(&mut sum.max).zip(&mut magnitude);
            for (((min, max), magnitude), (lo, hi)) in sides.zip(own.min.iter().zip(&own.max)) {
                let (a, b) = (weight * lo, weight * hi);
                *min += lesser(a, b);
                *max += greater(a, b);
                *magnitude += greater(a.abs(), b.abs());
            }
        }
        // Roundings of a product, of the step and of one sum for each shape, here and in the shaping of vertices.
        let slack = 2.0 * (weights.len() as f32 + 4.0) * f32::EPSILON;
        let sides = sum.min.iter_mut().zip(&mut sum.max).zip(magnitude);
        sides.for_each(|((min, max), magnitude)| {
            *min -= slack * magnitude;
            *max += slack * magnitude;
        });
        sum
    }

    fn check_shape(&self, shape: usize, vertex: usize) -> Option<()> {
        let vertex_len = self.0.layout.counts[place::VERTICES] as usize;
        (shape < self.shape_len() && vertex < vertex_len).then_some(())
    }
}
