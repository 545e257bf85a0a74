//! A skin in a loaded file, accessors to its arrays, and the hash of its rest mesh.

use super::counts::{NormalErrors, RULES, SkinCounts, place};
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::format::{SectionKind, crc};
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
const RANGES: usize = Rule::place(&RULES, SectionKind::Ranges);
/// `None` without the feature `normals`: the reader then ignores the section.
const COEFFICIENTS: Option<usize> = known(SectionKind::TangentCoefficients);
const NORMAL_ERRORS: Option<usize> = known(SectionKind::NormalErrors);

const fn known(section: SectionKind) -> Option<usize> {
    if cfg!(feature = "normals") { Some(Rule::place(&RULES, section)) } else { None }
}

/// Mesh of V vertices that follows a palette; borrowed from a loaded model.
///
/// Accessors by index return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Skin<'a>(pub(crate) Part<'a>);

part::view! { Skin, Skin, |words| -> SkinCounts { SkinCounts::from_words(first_counts(words)) } }

impl<'a> Skin<'a> {
    /// Returns the part whose palette the skin follows.
    ///
    /// `None` without an envelope, for example for a face without joints.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn envelope_part(&self) -> Option<usize> {
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

    /// Returns L, the number of transforms in the palette; 0 without an envelope.
    pub const fn palette_len(&self) -> usize {
        self.0.layout.counts[place::PALETTE] as usize
    }

    /// Returns S, the number of shapes.
    pub const fn shape_len(&self) -> usize {
        self.0.layout.counts[place::SHAPES] as usize
    }

    /// Whether the skin has rest tangents.
    pub const fn has_tangents(&self) -> bool {
        self.0.layout.has(TANGENTS)
    }

    /// Whether the skin has tangent coefficients for its normals and tangents. Without them normals use cofactors.
    pub const fn has_coefficients(&self) -> bool {
        matches!(COEFFICIENTS, Some(place) if self.0.layout.has(place))
    }

    /// Lists the named ranges of vertices: the meshes of the source.
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

    /// Lists the K influences of a vertex: palette index and weight. Unused influences have the weight 0.
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

    /// Lists the tangent coefficients g, h of a vertex, per unit of length, for the first K - 1 influences.
    ///
    /// The coefficients of the last influence are minus the sums of the others. Lists nothing without tangent
    /// coefficients.
    pub fn tangent_coefficients(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = [f32; 2]> + use<'a> {
        let len = self.influence_len().saturating_sub(1);
        let span = vertex.checked_mul(len).and_then(|start| Some(start..start.checked_add(len)?));
        let pairs = span.and_then(|span| self.coefficients().get(span)).unwrap_or_default();
        pairs.iter().map(|le| halves(u32::from_le_bytes(*le)))
    }

    /// Returns the measured errors of the normals; `None` if the file has none.
    pub fn normal_errors(&self) -> Option<NormalErrors> {
        let figures = self.0.entry(NORMAL_ERRORS?, 1, 0)?;
        Some(NormalErrors::from_figures(floats(figures)))
    }

    /// Lists the V rest positions.
    pub fn rest_positions(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        self.positions().iter().take(self.vertex_len()).map(floats)
    }

    /// Lists the V rest normals.
    pub fn rest_normals(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        self.normals().iter().take(self.vertex_len()).map(floats)
    }

    /// Returns the hash of the rest positions: [`mesh_hash_of`] in the file's order.
    ///
    /// Compare the hash after a reload, to detect a changed mesh or vertex order.
    pub fn mesh_hash(&self) -> u32 {
        self.positions().iter().take(self.vertex_len()).fold(0, with_vertex)
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

    pub(crate) fn range_rows(&self) -> &'a [[Le; 2]] {
        self.0.array(RANGES)
    }
}

/// Computes the hash of a mesh: a chained CRC-32 over the rest positions, starting at 0.
///
/// The bytes of a vertex are the hash so far and the three coordinates, all as little-endian u32.
///
/// - `positions`: rest positions in the file's order. An engine can pass the positions that it read from the file.
///
/// ```
/// use sinew_runtime::mesh_hash_of;
///
/// let hash = mesh_hash_of(&[[0.0, 1.0, 2.0], [0.5, 1.0, 2.0]]);
/// assert_ne!(hash, mesh_hash_of(&[[0.5, 1.0, 2.0], [0.0, 1.0, 2.0]]));
/// ```
pub fn mesh_hash_of(positions: &[[f32; 3]]) -> u32 {
    positions.iter().fold(0, |hash, position| with_vertex(hash, &position.map(f32::to_le_bytes)))
}

fn with_vertex(hash: u32, position: &[Le; 3]) -> u32 {
    crc::of(&[&hash.to_le_bytes(), position.as_flattened()])
}
