//! What a skin holds of its shapes.

use super::super::bounds::Bounds;
use super::super::counts::{BLOCK, RULES, ShapeErrors, place};
use super::super::view::Skin;
use super::blocks::{Blocks, SHAPES};
use crate::format::rule::Rule;
use crate::format::{Element, SectionKind};
use crate::linear::{Le, floats};

const ERRORS: usize = Rule::place(&RULES, SectionKind::ShapeErrors);

impl<'a> Skin<'a> {
    /// Returns what its deltas and slopes are: f32, f16 or i8.
    pub fn shape_element(&self) -> Element {
        Blocks::of(self).deltas.element
    }

    /// Returns how far a shape moves a vertex at a weight of 1; 0 where it does not.
    pub fn shape_delta(&self, shape: usize, vertex: usize) -> Option<[f32; 3]> {
        self.check_shape(shape, vertex)?;
        let blocks = Blocks::of(self);
        let delta = |entry| blocks.delta(entry, vertex);
        Some(blocks.entry(vertex / BLOCK, shape).and_then(delta).unwrap_or_default())
    }

    /// Returns how a shape tilts the surface at a vertex at a weight of 1: by how much it rises along each of the two
    /// directions of the vertex's frame at rest; 0 where it does not.
    pub fn shape_slopes(&self, shape: usize, vertex: usize) -> Option<[f32; 2]> {
        self.check_shape(shape, vertex)?;
        let blocks = Blocks::of(self);
        let slopes = |entry| blocks.slopes(entry, vertex);
        Some(blocks.entry(vertex / BLOCK, shape).and_then(slopes).unwrap_or_default())
    }

    /// Lists the shapes that move a vertex, and how far at a weight of 1. None beyond the mesh.
    pub fn deltas_of(&self, vertex: usize) -> impl Iterator<Item = (usize, [f32; 3])> + use<'a> {
        let blocks = Blocks::of(self);
        blocks
            .entries_of(vertex / BLOCK)
            .filter_map(move |entry| Some((entry.shape, blocks.delta(entry, vertex)?)))
    }

    /// Returns the box of how far a shape moves any vertex at a weight of 1, 0 among it.
    pub fn shape_box(&self, shape: usize) -> Option<Bounds> {
        let row: &[Le; 8] = self.0.entry(SHAPES, self.shape_len(), shape)?;
        Bounds::from_corners(row.last_chunk()?)
    }

    /// Returns how far its shapes were measured to be from those that were baked; `None` where the file does not say.
    pub fn shape_errors(&self) -> Option<ShapeErrors> {
        let figures = self.0.entry(ERRORS, 1, 0)?;
        Some(ShapeErrors::from_figures(floats(figures)))
    }

    fn check_shape(&self, shape: usize, vertex: usize) -> Option<()> {
        let vertex_len = self.0.layout.counts[place::VERTICES] as usize;
        (shape < self.shape_len() && vertex < vertex_len).then_some(())
    }
}
