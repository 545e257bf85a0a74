//! A skin in a loaded file: what loading found of it, and what it holds.

use super::bounds::Bounds;
use super::counts::{NormalErrors, RULES, SkinCounts, place};
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::{Le, floats};
use crate::names::Names;
use crate::numeric::halves;
use core::ops::Range;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const POSITIONS: usize = Rule::place(&RULES, SectionKind::RestPositions);
const NORMALS: usize = Rule::place(&RULES, SectionKind::RestNormals);
const TANGENTS: usize = Rule::place(&RULES, SectionKind::RestTangents);
const INDICES: usize = Rule::place(&RULES, SectionKind::InfluenceIndices);
const WEIGHTS: usize = Rule::place(&RULES, SectionKind::InfluenceWeights);
const BOXES: usize = Rule::place(&RULES, SectionKind::RestBoxes);
const RANGES: usize = Rule::place(&RULES, SectionKind::Ranges);
/// The places of what a reader without the feature `tangent-coefficients` leaves alone.
const COEFFICIENTS: Option<usize> = known(SectionKind::TangentCoefficients);
const NORMAL_ERRORS: Option<usize> = known(SectionKind::NormalErrors);

const fn known(section: SectionKind) -> Option<usize> {
    if cfg!(feature = "tangent-coefficients") { Some(Rule::place(&RULES, section)) } else { None }
}

/// A mesh of V vertices that follows a palette; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Skin<'a>(pub(crate) Part<'a>);

part::view! { Skin, SkinLayout, |words| -> SkinCounts { SkinCounts::from_words(first_counts(words)) } }

impl<'a> Skin<'a> {
    /// Returns the part whose palette it follows; `None` if it follows none, as a face without joints.
    pub fn envelope_part(&self) -> Option<usize> {
        self.counts().envelope().map(usize::from)
    }

    /// Returns V, the number of vertices.
    pub const fn vertex_len(&self) -> usize {
        self.0.layout.counts[place::VERTICES] as usize
    }

    /// Returns K, the number of influences of a vertex.
    pub const fn influence_len(&self) -> usize {
        self.0.layout.counts[place::INFLUENCES] as usize
    }

    /// Returns the number of transforms of the palette that it takes; 0 without an envelope.
    pub const fn palette_len(&self) -> usize {
        self.0.layout.counts[place::PALETTE] as usize
    }

    /// Returns S, the number of shapes.
    pub const fn shape_len(&self) -> usize {
        self.0.layout.counts[place::SHAPES] as usize
    }

    /// Whether it has tangents.
    pub const fn has_tangents(&self) -> bool {
        self.0.layout.has(TANGENTS)
    }

    /// Whether it has tangent coefficients, by which normals and tangents are then turned; else they go by
    /// cofactors.
    pub const fn has_coefficients(&self) -> bool {
        matches!(COEFFICIENTS, Some(place) if self.0.layout.has(place))
    }

    /// Lists the named ranges of vertices: the meshes that it was made of.
    pub fn ranges(&self) -> impl Iterator<Item = (&'a str, Range<usize>)> + use<'a> {
        let names = self.names();
        self.range_rows().iter().zip(1..).map_while(move |([start, end], name)| {
            let index = |le: &Le| u32::from_le_bytes(*le) as usize;
            Some((names.get(name)?, index(start)..index(end)))
        })
    }

    /// Returns a shape's name.
    pub fn shape_name(&self, shape: usize) -> Option<&'a str> {
        let own = Some(shape).filter(|shape| *shape < self.shape_len())?;
        self.names().get(1 + self.range_rows().len() + own)
    }

    /// Returns a vertex's rest position.
    pub fn rest_position(&self, vertex: usize) -> Option<[f32; 3]> {
        self.0.entry(POSITIONS, self.vertex_len(), vertex).map(floats)
    }

    /// Returns a vertex's rest normal.
    pub fn rest_normal(&self, vertex: usize) -> Option<[f32; 3]> {
        self.0.entry(NORMALS, self.vertex_len(), vertex).map(floats)
    }

    /// Returns a vertex's rest tangent and, last, its handedness.
    pub fn rest_tangent(&self, vertex: usize) -> Option<[f32; 4]> {
        self.0.entry(TANGENTS, self.vertex_len(), vertex).map(floats)
    }

    /// Lists a vertex's K influences: palette index and weight. Unused ones weigh 0.
    pub fn influences(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = (usize, f32)> + use<'a> {
        let k = self.influence_len();
        let span = vertex.checked_mul(k).and_then(|start| Some(start..start.checked_add(k)?));
        let indices = span.clone().and_then(|span| self.indices().get(span)).unwrap_or_default();
        let weights = span.and_then(|span| self.weights().get(span)).unwrap_or_default();
        indices.iter().zip(weights).map(|(index, weight)| {
            (usize::from(u16::from_le_bytes(*index)), f32::from_le_bytes(*weight))
        })
    }

    /// Lists a vertex's tangent coefficients g, h, per unit of length, of its first K - 1 influences; those of the
    /// last are minus their sums. None where it has none.
    pub fn tangent_coefficients(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = [f32; 2]> + use<'a> {
        let len = self.influence_len().saturating_sub(1);
        let span = vertex.checked_mul(len).and_then(|start| Some(start..start.checked_add(len)?));
        let pairs = span.and_then(|span| self.coefficients().get(span)).unwrap_or_default();
        pairs.iter().map(|le| halves(u32::from_le_bytes(*le)))
    }

    /// Returns how far its normals were measured to be from the true ones; `None` where the file does not say.
    pub fn normal_errors(&self) -> Option<NormalErrors> {
        let figures = self.0.entry(NORMAL_ERRORS?, 1, 0)?;
        Some(NormalErrors::from_figures(floats(figures)))
    }

    /// Returns the box of the rest positions that a transform of the palette moves; `None` if it moves
    /// none.
    pub fn rest_box(&self, index: usize) -> Option<Bounds> {
        self.0.entry(BOXES, self.palette_len(), index).and_then(Bounds::from_corners)
    }

    pub(crate) fn names(&self) -> Names<'a> {
        let len = self.range_rows().len() + self.shape_len() + 1;
        Names::new(self.0.bytes(NAMES), len)
    }

    pub(crate) fn positions(&self) -> &'a [[Le; 3]] {
        self.0.array(POSITIONS)
    }

    pub(crate) fn normals(&self) -> &'a [[Le; 3]] {
        self.0.array(NORMALS)
    }

    pub(crate) fn tangents(&self) -> &'a [[Le; 4]] {
        self.0.array(TANGENTS)
    }

    pub(crate) fn indices(&self) -> &'a [[u8; 2]] {
        self.0.bytes(INDICES).as_chunks().0
    }

    pub(crate) fn weights(&self) -> &'a [Le] {
        self.0.bytes(WEIGHTS).as_chunks().0
    }

    pub(crate) fn coefficients(&self) -> &'a [Le] {
        COEFFICIENTS.map_or(&[], |place| self.0.bytes(place).as_chunks().0)
    }

    pub(crate) fn boxes(&self) -> &'a [[Le; 6]] {
        self.0.array(BOXES)
    }

    pub(crate) fn range_rows(&self) -> &'a [[Le; 2]] {
        self.0.array(RANGES)
    }
}
