//! A skin in a loaded file: what loading found of it, and what it holds.

use super::bounds::Bounds;
use super::counts::{RULES, SkinCounts};
use crate::format::rule::Rule;
use crate::format::{FileId, SectionKind, Span};
use crate::linear::{Le, floats};
use crate::names::Names;
use core::fmt;
use core::ops::Range;

/// What loading found of a skin: its counts, and where its arrays lie. It borrows nothing, so that it
/// can be kept beside the model, and views be made of it each frame.
#[derive(Clone, Copy, Debug)]
pub struct SkinLayout {
    file: FileId,
    part: u16,
    counts: SkinCounts,
    palette_len: u32,
    /// Where its sections lie, in the order of [`super::SKIN_SECTIONS`].
    spans: [Span; RULES.len()],
}

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const POSITIONS: usize = Rule::place(&RULES, SectionKind::RestPositions);
const NORMALS: usize = Rule::place(&RULES, SectionKind::RestNormals);
const TANGENTS: usize = Rule::place(&RULES, SectionKind::RestTangents);
const INDICES: usize = Rule::place(&RULES, SectionKind::InfluenceIndices);
const WEIGHTS: usize = Rule::place(&RULES, SectionKind::InfluenceWeights);
const BOXES: usize = Rule::place(&RULES, SectionKind::RestBoxes);
const RANGES: usize = Rule::place(&RULES, SectionKind::Ranges);

impl SkinLayout {
    /// Makes the layout of a part, of an envelope with a palette of so many; where its sections lie
    /// is to be found.
    pub(crate) const fn new(file: FileId, part: u16, counts: SkinCounts, palette_len: u32) -> Self {
        Self { file, part, counts, palette_len, spans: [Span::NONE; RULES.len()] }
    }

    /// Lends where its sections lie, in the order of [`super::SKIN_SECTIONS`].
    pub(crate) const fn spans_mut(&mut self) -> &mut [Span; RULES.len()] {
        &mut self.spans
    }

    /// Returns the skin; `None` if the bytes are not those of the file in which it was found, by their
    /// length and the checksum that they state.
    ///
    /// Nothing is read again. Of bytes that have changed otherwise the skin gives wrong numbers, but
    /// never panics.
    pub fn open<'a>(&self, file: &'a [u8]) -> Option<Skin<'a>> {
        (FileId::of(file) == Some(self.file)).then_some(Skin { layout: *self, file })
    }

    /// Returns the counts.
    pub const fn counts(&self) -> SkinCounts {
        self.counts
    }
}

/// A mesh of V vertices that follows a palette; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Skin<'a> {
    layout: SkinLayout,
    file: &'a [u8],
}

impl<'a> Skin<'a> {
    /// Views a skin in the file in which it was found.
    pub(crate) const fn new(layout: SkinLayout, file: &'a [u8]) -> Self {
        Self { layout, file }
    }

    /// Returns what loading found, to open it again.
    pub const fn layout(&self) -> SkinLayout {
        self.layout
    }

    /// Tells in which file it is.
    pub const fn file(&self) -> FileId {
        self.layout.file
    }

    /// Returns its place in [`crate::Model::parts`], by which [`crate::Model::sections`] are told
    /// apart.
    pub fn part(&self) -> usize {
        self.layout.part.into()
    }

    /// Returns the part's name.
    pub fn name(&self) -> &'a str {
        self.names().get(0).unwrap_or_default()
    }

    /// Returns its counts.
    pub const fn counts(&self) -> SkinCounts {
        self.layout.counts
    }

    /// Returns the part whose palette it follows; `None` if it follows none, as a face without joints.
    pub fn envelope_part(&self) -> Option<usize> {
        self.counts().envelope().map(usize::from)
    }

    /// Returns V, the number of vertices.
    pub const fn vertex_len(&self) -> usize {
        self.layout.counts.vertex_len as usize
    }

    /// Returns K, the number of influences of a vertex.
    pub const fn influence_len(&self) -> usize {
        self.layout.counts.influence_len as usize
    }

    /// Returns the number of transforms of the palette that it takes; 0 without an envelope.
    pub const fn palette_len(&self) -> usize {
        self.layout.palette_len as usize
    }

    /// Whether it has tangents.
    pub const fn has_tangents(&self) -> bool {
        self.layout.spans[TANGENTS].is_some()
    }

    /// Lists the named ranges of vertices: the meshes that it was made of.
    pub fn ranges(&self) -> impl Iterator<Item = (&'a str, Range<usize>)> + use<'a> {
        let names = self.names();
        self.range_rows().iter().zip(1..).map_while(move |([start, end], name)| {
            let index = |le: &Le| u32::from_le_bytes(*le) as usize;
            Some((names.get(name)?, index(start)..index(end)))
        })
    }

    /// Returns a vertex's rest position.
    pub fn rest_position(&self, vertex: usize) -> Option<[f32; 3]> {
        self.positions().get(vertex).map(floats)
    }

    /// Returns a vertex's rest normal.
    pub fn rest_normal(&self, vertex: usize) -> Option<[f32; 3]> {
        self.normals().get(vertex).map(floats)
    }

    /// Returns a vertex's rest tangent and, last, its handedness.
    pub fn rest_tangent(&self, vertex: usize) -> Option<[f32; 4]> {
        self.tangents().get(vertex).map(floats)
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

    /// Returns the box of the rest positions that a transform of the palette moves; `None` if it moves
    /// none.
    pub fn rest_box(&self, index: usize) -> Option<Bounds> {
        self.boxes().get(index).and_then(Bounds::from_corners)
    }

    pub(crate) fn names(&self) -> Names<'a> {
        Names::new(self.bytes(NAMES), self.range_rows().len() + 1)
    }

    pub(crate) fn positions(&self) -> &'a [[Le; 3]] {
        self.array(POSITIONS)
    }

    pub(crate) fn normals(&self) -> &'a [[Le; 3]] {
        self.array(NORMALS)
    }

    pub(crate) fn tangents(&self) -> &'a [[Le; 4]] {
        self.array(TANGENTS)
    }

    pub(crate) fn indices(&self) -> &'a [[u8; 2]] {
        self.bytes(INDICES).as_chunks().0
    }

    pub(crate) fn weights(&self) -> &'a [Le] {
        self.bytes(WEIGHTS).as_chunks().0
    }

    pub(crate) fn boxes(&self) -> &'a [[Le; 6]] {
        self.array(BOXES)
    }

    pub(crate) fn range_rows(&self) -> &'a [[Le; 2]] {
        self.array(RANGES)
    }

    pub(crate) const fn spans(&self) -> &[Span] {
        &self.layout.spans
    }

    pub(crate) const fn file_bytes(&self) -> &'a [u8] {
        self.file
    }

    /// Cuts a section into arrays of N words.
    fn array<const N: usize>(&self, place: usize) -> &'a [[Le; N]] {
        self.bytes(place).as_chunks().0.as_chunks().0
    }

    /// Returns a section's bytes; none of one that it has not.
    fn bytes(&self, place: usize) -> &'a [u8] {
        self.layout.spans.get(place).unwrap_or(&Span::NONE).bytes(self.file)
    }
}

impl fmt::Debug for Skin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, counts) = (self.name(), self.counts());
        f.debug_struct("Skin").field("name", &name).field("counts", &counts).finish()
    }
}
