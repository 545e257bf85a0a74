//! A skin in a loaded file, accessors to its arrays, and the hash of its rest mesh.

use super::counts::{EIGHT, NormalErrors, RULES, SkinCounts, place};
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::format::{SectionKind, crc};
use crate::linear::{Le, floats};
use crate::names::Names;
use crate::numeric::halves;
use core::array;
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
        self.checked(vertex).and_then(|vertex| of_vertex(self.positions(), vertex))
    }

    /// Returns a vertex's rest normal.
    pub fn rest_normal(&self, vertex: usize) -> Option<[f32; 3]> {
        self.checked(vertex).and_then(|vertex| of_vertex(self.normals(), vertex))
    }

    /// Returns a vertex's rest tangent and, last, its handedness.
    pub fn rest_tangent(&self, vertex: usize) -> Option<[f32; 4]> {
        self.checked(vertex).and_then(|vertex| of_vertex(self.tangents(), vertex))
    }

    /// Lists the K influences of a vertex: palette index and weight. Unused influences have the weight 0.
    pub fn influences(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = (usize, f32)> + use<'a> {
        let len = self.influence_len();
        let rows = self.checked(vertex).and_then(|vertex| {
            Some((rows_of(self.indices(), len, vertex)?, rows_of(self.weights(), len, vertex)?))
        });
        let (indices, weights) = rows.unwrap_or_default();
        indices.iter().zip(weights).map(move |(indices, weights)| {
            let index = u16::from_le_bytes(indices[vertex % EIGHT]);
            (usize::from(index), f32::from_le_bytes(weights[vertex % EIGHT]))
        })
    }

    /// Lists the tangent coefficients g, h of a vertex, per unit of length, for all influences but the first.
    ///
    /// The coefficients of the first influence are minus the sums of the others. Lists nothing without tangent
    /// coefficients.
    pub fn tangent_coefficients(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = [f32; 2]> + use<'a> {
        let len = self.influence_len().saturating_sub(1);
        let rows = self.checked(vertex).and_then(|at| rows_of(self.coefficients(), len, at));
        let rows = rows.unwrap_or_default().iter();
        rows.map(move |words| halves(u32::from_le_bytes(words[vertex % EIGHT])))
    }

    /// Returns the measured errors of the normals; `None` if the file has none.
    pub fn normal_errors(&self) -> Option<NormalErrors> {
        let figures = self.0.entry(NORMAL_ERRORS?, 1, 0)?;
        Some(NormalErrors::from_figures(floats(figures)))
    }

    /// Lists the V rest positions.
    pub fn rest_positions(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        let skin = *self;
        (0..skin.vertex_len()).map(move |vertex| skin.rest_position(vertex).unwrap_or_default())
    }

    /// Lists the V rest normals.
    pub fn rest_normals(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        let skin = *self;
        (0..skin.vertex_len()).map(move |vertex| skin.rest_normal(vertex).unwrap_or_default())
    }

    /// Returns the hash of the rest positions: [`mesh_hash_of`] in the file's order.
    ///
    /// Compare the hash after a reload, to detect a changed mesh or vertex order.
    pub fn mesh_hash(&self) -> u32 {
        self.rest_positions()
            .fold(0, |hash, position| with_vertex(hash, &position.map(f32::to_le_bytes)))
    }

    pub(crate) fn names(&self) -> Names<'a> {
        let len = self.range_rows().len() + self.shape_len() + 1;
        Names::new(self.0.bytes(NAMES), len)
    }

    /// Returns a vertex that is in the mesh: not in the padding of the last block.
    fn checked(&self, vertex: usize) -> Option<usize> {
        Some(vertex).filter(|vertex| *vertex < self.vertex_len())
    }

    pub(crate) fn positions(&self) -> &'a [[Row; 3]] {
        self.0.array(POSITIONS).as_chunks().0
    }

    pub(crate) fn normals(&self) -> &'a [[Row; 3]] {
        self.0.array(NORMALS).as_chunks().0
    }

    pub(crate) fn tangents(&self) -> &'a [[Row; 4]] {
        self.0.array(TANGENTS).as_chunks().0
    }

    /// Returns the indices of influences, K rows for each block.
    pub(crate) fn indices(&self) -> &'a [[[u8; 2]; EIGHT]] {
        self.0.bytes(INDICES).as_chunks().0.as_chunks().0
    }

    /// Returns the weights of influences, K rows for each block.
    pub(crate) fn weights(&self) -> &'a [Row] {
        self.0.array(WEIGHTS)
    }

    /// Returns the tangent coefficients as pairs of f16, K - 1 rows for each block.
    pub(crate) fn coefficients(&self) -> &'a [Row] {
        COEFFICIENTS.map_or(&[], |place| self.0.array(place))
    }

    pub(crate) fn range_rows(&self) -> &'a [[Le; 2]] {
        self.0.array(RANGES)
    }
}

/// A number of each vertex of a block.
pub(crate) type Row = [Le; EIGHT];

/// Reads a number of a vertex from its row.
#[inline(always)]
pub(crate) fn float(row: &Row, lane: usize) -> f32 {
    f32::from_le_bytes(row[lane % EIGHT])
}

/// Reads N numbers of a vertex from the blocks of an attribute.
#[inline(always)]
pub(crate) fn of_vertex<const N: usize>(blocks: &[[Row; N]], vertex: usize) -> Option<[f32; N]> {
    let rows = blocks.get(vertex / EIGHT)?;
    Some(array::from_fn(|n| float(&rows[n], vertex)))
}

/// Returns the rows of a vertex's block: `len` for each block.
#[inline(always)]
pub(crate) fn rows_of<T>(rows: &[T], len: usize, vertex: usize) -> Option<&[T]> {
    rows.get(vertex / EIGHT * len..)?.get(..len)
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
