//! The numbers of an object: how large it is, how good it is.

use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};

/// Stands for no point: in the row of a triangle, which has no fourth.
pub const NO_POINT: u16 = u16::MAX;

/// Counts of an object, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewsCounts {
    /// Control points, K.
    pub point_len: u32,
    /// Elements, E.
    pub element_len: u32,
    /// Key views, N.
    pub view_len: u32,
    /// Maps, M.
    pub map_len: u32,
    /// Textures, T.
    pub texture_len: u32,
    /// Texels of all textures.
    pub texel_len: u32,
}

impl ViewsCounts {
    /// Bytes of section `views_counts`.
    pub const BYTES: usize = 24;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 6] {
        let Self { point_len, element_len, view_len, map_len, texture_len, texel_len } = *self;
        [point_len, element_len, view_len, map_len, texture_len, texel_len]
    }

    /// Makes them of their words.
    pub const fn from_words(words: [u32; 6]) -> Self {
        let [point_len, element_len, view_len, map_len, texture_len, texel_len] = words;
        Self { point_len, element_len, view_len, map_len, texture_len, texel_len }
    }

    /// Returns how many numbers a map of the object gives: K places with their depth, K visibilities, N scores.
    pub const fn result_len(&self) -> usize {
        (self.point_len as usize).saturating_mul(4).saturating_add(self.view_len as usize)
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no object has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let Self { point_len: k, element_len: e, view_len: n, .. } = *self;
        let Self { map_len: m, texture_len: t, texel_len, .. } = *self;
        let deformation = k.saturating_mul(2).saturating_add(1);
        Asked::new(ALWAYS, [1, k, e, n, m, t, texel_len, mask_len(k), deformation])
    }
}

/// Counts the words of a mask with a bit a point.
pub(crate) const fn mask_len(point_len: u32) -> u32 {
    point_len.div_ceil(32)
}

/// When another key view takes over by default, and what an object was measured to reach. Lengths are in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewsFit {
    /// By how much a key view's score must be above that of the one before.
    pub margin: f32,
    /// RMS over points and examples of the distance between the examples' points and the maps'.
    pub rms_error: f32,
    /// The same, each example left out of its own fit; 0 if it was not measured.
    pub left_out_rms: f32,
    /// Share of the points whose visibility the maps give as the examples do.
    pub visibility: f32,
}

impl ViewsFit {
    /// Bytes of section `views_fit`.
    pub const BYTES: usize = 16;

    /// Lists its figures in the order of the file.
    pub const fn figures(&self) -> [f32; 4] {
        let Self { margin, rms_error, left_out_rms, visibility } = *self;
        [margin, rms_error, left_out_rms, visibility]
    }

    /// Makes it of its figures.
    pub const fn from_figures([margin, rms_error, left_out_rms, visibility]: [f32; 4]) -> Self {
        Self { margin, rms_error, left_out_rms, visibility }
    }
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const POINTS: usize = 0;
    pub(crate) const ELEMENTS: usize = 1;
    pub(crate) const VIEWS: usize = 2;
    pub(crate) const MAPS: usize = 3;
    pub(crate) const TEXTURES: usize = 4;
    pub(crate) const TEXELS: usize = 5;
}

/// The sections of an object, in the order in which the trainer writes them.
pub const VIEWS_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && ViewsCounts::BYTES <= 4 * COUNTS);

/// What an object asks of its sections. Sizes: 1, K, E, N, M, T, texels, words of a mask of K bits, floats of a view's
/// deformation.
pub(crate) const RULES: [Rule; 11] = [
    Rule::new(SectionKind::ViewsCounts, ViewsCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [3, 0]).or_more(4),
    Rule::new(SectionKind::Maps, 4, [4, 0]),
    Rule::new(SectionKind::Elements, 8, [2, 0]),
    Rule::new(SectionKind::ViewTextures, 4, [3, 0]),
    Rule::floats(SectionKind::References, 8, [3, 1]),
    Rule::new(SectionKind::ViewMasks, 4, [3, 7]),
    Rule::new(SectionKind::Textures, 12, [5, 0]),
    Rule::new(SectionKind::Texels, 4, [6, 0]),
    Rule::floats(SectionKind::Deformations, 4, [3, 8]).with(OPTIONAL),
    Rule::floats(SectionKind::ViewsFit, ViewsFit::BYTES as u8, [0, 0]).unsigned(),
];
