//! Counts of a skin, its measured errors, and the rules for its sections.

use crate::format::flat::flat;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};
use crate::format::{Element, SectionKind};

/// Allowed difference of a vertex's sum of weights from 1; the rounding of 32 influences is below 4e-6.
pub const WEIGHT_SUM_TOLERANCE: f32 = 1.0e-5;
/// Allowed difference of the squared length of a normal or tangent from 1.
///
/// The rounding of three floats and of their squares is below 5e-7.
pub const LENGTH_TOLERANCE: f32 = 1.0e-5;
/// Sentinel for "no envelope" in [`SkinCounts::envelope`].
pub const NO_ENVELOPE: u32 = u32::MAX;

/// Counts of a skin. The length of every section follows from them and from the envelope's palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkinCounts {
    /// Vertices, V.
    pub vertex_len: u32,
    /// Influences of a vertex, K; 0 without an envelope.
    pub influence_len: u32,
    /// Part whose palette the skin follows, or [`NO_ENVELOPE`].
    pub envelope: u32,
    /// Named ranges of vertices, R.
    pub range_len: u32,
    /// Shapes, S.
    pub shape_len: u32,
    /// Pairs of a block of vertices and a shape that moves some of them, E; 0 without shapes.
    pub entry_len: u32,
    /// Pairs of a vertex and a shape that moves it, D; 0 without shapes.
    pub delta_len: u32,
}

flat! { SkinCounts of "skin_counts", words, from_words: [u32; 7] {
    vertex_len, influence_len, envelope, range_len, shape_len, entry_len, delta_len
} }

impl SkinCounts {
    /// Returns the part whose palette the skin follows; `None` without an envelope.
    pub fn envelope(&self) -> Option<u16> {
        u16::try_from(self.envelope).ok()
    }

    /// Returns whether a skin with these counts must have a section (true), may have it (`None`), or has not (false).
    pub fn has(&self, section: SectionKind) -> Option<bool> {
        let Some(rule) = Rule::of(&RULES, section) else { return Some(false) };
        let has = rule.has == OPTIONAL || self.asked(0, Element::F32).has & rule.has != 0;
        if has && rule.has & OPTIONAL != 0 { None } else { Some(has) }
    }

    /// Computes the length of a section in bytes; `None` if the product overflows, or no skin has the section.
    ///
    /// For the names the result is the least length.
    ///
    /// - `palette_len`: transforms of the envelope's palette, L.
    /// - `element`: type of the deltas and slopes of shapes.
    pub fn section_bytes(
        &self,
        section: SectionKind,
        palette_len: usize,
        element: Element,
    ) -> Option<u64> {
        let palette_len = u32::try_from(palette_len).ok()?;
        Rule::of(&RULES, section)?.bytes(&self.asked(palette_len, element).sizes)
    }

    /// Counts the names after the name of the part, R + S.
    pub(crate) const fn name_len(&self) -> u32 {
        self.range_len.saturating_add(self.shape_len)
    }

    /// Returns the flags and sizes that [`RULES`] refer to.
    pub(crate) const fn asked(&self, palette_len: u32, element: Element) -> Asked {
        let Self { vertex_len: v, influence_len: k, range_len: r, shape_len: s, .. } = *self;
        let p = v.saturating_add(EIGHT as u32 - 1) & !(EIGHT as u32 - 1);
        let follows = if self.envelope == NO_ENVELOPE { 0 } else { FOLLOWS };
        let blends = if follows != 0 && k > 1 { BLENDS } else { 0 };
        let shaped = if s > 0 { SHAPED } else { 0 };
        let has = ALWAYS | follows | blends | shaped;
        let (names, others) = (self.name_len(), k.saturating_sub(1));
        #[cfg(feature = "shapes")]
        {
            let (e, d, width) = (self.entry_len, self.delta_len, element.bytes() as u32);
            let starts = v.div_ceil(BLOCK as u32) + 1;
            Asked::new(has, [1, p, k, palette_len, r, names, others, s, starts, e, d, width])
        }
        #[cfg(all(not(feature = "shapes"), feature = "normals"))]
        {
            let _ = element;
            Asked::new(has, [1, p, k, palette_len, r, names, others])
        }
        #[cfg(not(any(feature = "shapes", feature = "normals")))]
        {
            let _ = (element, others);
            Asked::new(has, [1, p, k, palette_len, r, names])
        }
    }
}

/// Measured errors of a skin's normals over the training poses: RMS of the angle, weighted by the area at rest, in
/// radians.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct NormalErrors {
    /// Error of the model's normals.
    pub model: f32,
    /// Error of the model's palette in a shader without tangent coefficients: normals by cofactors.
    pub cofactors: f32,
    /// Error of the normals of linear blend skinning, by cofactors.
    pub lbs: f32,
}

flat! { NormalErrors of "normal_errors", figures, from_figures: [f32; 3] { model, cofactors, lbs } }

/// Measured errors of the shapes in the file against the source of the bake, each shape at a weight of 1.
///
/// Lengths are in the file's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct ShapeErrors {
    /// Largest error of any vertex of any shape.
    pub largest: f32,
    /// RMS error over all pairs of a shape and a vertex that it moves.
    pub rms: f32,
}

flat! { ShapeErrors of "shape_errors", figures, from_figures: [f32; 2] { largest, rms } }

/// Positions of the counts in their section. Two values follow that loading adds: the length of the envelope's palette,
/// and the element type of the deltas.
pub(crate) mod place {
    pub(crate) const VERTICES: usize = 0;
    pub(crate) const INFLUENCES: usize = 1;
    pub(crate) const ENVELOPE: usize = 2;
    pub(crate) const SHAPES: usize = 4;
    #[cfg(feature = "shapes")]
    pub(crate) const ENTRIES: usize = 5;
    #[cfg(feature = "shapes")]
    pub(crate) const DELTAS: usize = 6;
    pub(crate) const PALETTE: usize = 7;
    #[cfg(feature = "shapes")]
    pub(crate) const ELEMENT: usize = 8;
}

/// Flag of a skin with an envelope.
const FOLLOWS: u8 = 4;
/// Flag of a skin with K > 1 influences for each vertex.
const BLENDS: u8 = 8;
/// Flag of a skin with shapes.
const SHAPED: u8 = 16;

/// Vertices of a block of attributes. A block holds a row of eight for each number of a vertex.
pub(crate) const EIGHT: usize = 8;
/// Vertices of a block of shapes, one bit of a mask for each vertex.
pub const BLOCK: usize = 64;

/// Sections of a skin, in the order of the trainer's files.
pub const SKIN_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && place::PALETTE < COUNTS);

/// Numbers of optional sections that the features read: for tangent coefficients, and for shapes.
const MORE: [usize; 2] =
    [2 * cfg!(feature = "normals") as usize, 6 * cfg!(feature = "shapes") as usize];

/// Rules for the sections of a skin. Sizes: 1, V padded to whole blocks of eight, K, L, R, R + S, K - 1, S, blocks + 1, E, D, bytes of an element.
pub(crate) const RULES: [Rule; 9 + MORE[0] + MORE[1]] = [
    Rule::new(SectionKind::SkinCounts, SkinCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [5, 0]).or_more(4),
    Rule::floats(SectionKind::RestPositions, 12, [1, 0]),
    Rule::floats(SectionKind::RestNormals, 12, [1, 0]),
    Rule::floats(SectionKind::RestTangents, 16, [1, 0]).with(OPTIONAL),
    Rule::new(SectionKind::InfluenceIndices, 2, [1, 2]).with(FOLLOWS),
    Rule::floats(SectionKind::InfluenceWeights, 4, [1, 2]).with(FOLLOWS).unsigned(),
    Rule::floats(SectionKind::RestBoxes, 24, [3, 0]).with(FOLLOWS),
    Rule::new(SectionKind::Ranges, 8, [4, 0]),
    #[cfg(feature = "normals")]
    Rule::new(SectionKind::TangentCoefficients, 4, [1, 6]).with(BLENDS | OPTIONAL),
    #[cfg(feature = "normals")]
    Rule::new(SectionKind::NormalErrors, NormalErrors::BYTES as u8, [0, 0])
        .with(OPTIONAL)
        .unsigned(),
    #[cfg(feature = "shapes")]
    Rule::floats(SectionKind::Shapes, 32, [7, 0]).with(SHAPED),
    #[cfg(feature = "shapes")]
    Rule::new(SectionKind::ShapeBlocks, 4, [8, 0]).with(SHAPED),
    #[cfg(feature = "shapes")]
    Rule::new(SectionKind::ShapeEntries, 16, [9, 0]).with(SHAPED),
    #[cfg(feature = "shapes")]
    Rule::new(SectionKind::ShapeDeltas, 3, [10, 11]).with(SHAPED),
    #[cfg(feature = "shapes")]
    Rule::new(SectionKind::ShapeSlopes, 2, [10, 11]).with(SHAPED),
    #[cfg(feature = "shapes")]
    Rule::new(SectionKind::ShapeErrors, ShapeErrors::BYTES as u8, [0, 0])
        .with(SHAPED | OPTIONAL)
        .unsigned(),
];
