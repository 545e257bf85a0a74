//! The numbers of an object: how large it is, how good it is.

use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};

/// Stands for no vertex, no neighbour: in the row of a triangle, which has no fourth of either, and beyond a border.
pub const NO_VERTEX: u16 = u16::MAX;
/// Stands for no texture of a layer in a key view, and for no layer that clips.
pub const NOTHING: u32 = u32::MAX;

/// The most layers that clip one layer: one that itself is clipped clips by that, too.
pub const CLIPS_MAX: usize = 8;
/// The most elements that clip, those of every layer that clips one counted once for that one.
pub const CLIP_ELEMENTS_MAX: usize = 1 << 20;
/// The most elements, those that clip counted again, times the key views: each is fitted to each.
pub const FITS_MAX: usize = 1 << 22;

/// Counts of an object, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewsCounts {
    /// Control points, K.
    pub point_len: u32,
    /// Vertices, V.
    pub vertex_len: u32,
    /// Weights of points in vertices, W.
    pub weight_len: u32,
    /// Elements, E.
    pub element_len: u32,
    /// Layers, L.
    pub layer_len: u32,
    /// Key views, N.
    pub view_len: u32,
    /// Maps, M.
    pub map_len: u32,
    /// Textures, T.
    pub texture_len: u32,
    /// Texels of all textures.
    pub texel_len: u32,
    /// Width and height of the screen on which points are, in pixels.
    pub size: [u32; 2],
}

impl ViewsCounts {
    /// Bytes of section `views_counts`.
    pub const BYTES: usize = 44;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 11] {
        let Self { point_len, vertex_len, weight_len, element_len, layer_len, .. } = *self;
        let Self { view_len, map_len, texture_len, texel_len, size: [width, height], .. } = *self;
        let [k, v, w, e] = [point_len, vertex_len, weight_len, element_len];
        let [l, n, m, t] = [layer_len, view_len, map_len, texture_len];
        [k, v, w, e, l, n, m, t, texel_len, width, height]
    }

    /// Makes them of their words.
    pub const fn from_words(words: [u32; 11]) -> Self {
        let [point_len, vertex_len, weight_len, element_len, layer_len, rest @ ..] = words;
        let [view_len, map_len, texture_len, texel_len, size @ ..] = rest;
        Self {
            point_len,
            vertex_len,
            weight_len,
            element_len,
            layer_len,
            view_len,
            map_len,
            texture_len,
            texel_len,
            size,
        }
    }

    /// Returns how many numbers a map of the object gives: K places with their depth, K visibilities, N scores, and of L
    /// layers opacity and order.
    pub const fn result_len(&self) -> usize {
        let points = (self.point_len as usize).saturating_mul(4);
        let layers = (self.layer_len as usize).saturating_mul(2);
        points.saturating_add(self.view_len as usize).saturating_add(layers)
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no object has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let Self { point_len: k, vertex_len: v, weight_len: w, element_len: e, .. } = *self;
        let Self { layer_len: l, view_len: n, map_len: m, texture_len: t, texel_len, .. } = *self;
        let deformation = k.saturating_mul(2).saturating_add(1);
        let named = n.saturating_add(l);
        Asked::new(ALWAYS, [1, k, v, w, e, l, n, m, t, texel_len, mask_len(k), deformation, named])
    }
}

/// Counts the words of a mask with a bit a point.
pub(crate) const fn mask_len(point_len: u32) -> u32 {
    point_len.div_ceil(32)
}

/// What an object was measured to reach. Lengths are in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewsFit {
    /// RMS over points and examples of the distance between the examples' points and the maps'.
    pub rms_error: f32,
    /// The same, each example left out of its own fit; 0 if it was not measured.
    pub left_out_rms: f32,
    /// Share of the points whose visibility the maps give as the examples do.
    pub visibility: f32,
}

impl ViewsFit {
    /// Bytes of section `views_fit`.
    pub const BYTES: usize = 12;

    /// Lists its figures in the order of the file.
    pub const fn figures(&self) -> [f32; 3] {
        let Self { rms_error, left_out_rms, visibility } = *self;
        [rms_error, left_out_rms, visibility]
    }

    /// Makes it of its figures.
    pub const fn from_figures([rms_error, left_out_rms, visibility]: [f32; 3]) -> Self {
        Self { rms_error, left_out_rms, visibility }
    }
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const POINTS: usize = 0;
    pub(crate) const VERTICES: usize = 1;
    pub(crate) const WEIGHTS: usize = 2;
    pub(crate) const ELEMENTS: usize = 3;
    pub(crate) const LAYERS: usize = 4;
    pub(crate) const VIEWS: usize = 5;
    pub(crate) const MAPS: usize = 6;
    pub(crate) const TEXTURES: usize = 7;
    pub(crate) const TEXELS: usize = 8;
    pub(crate) const SIZE: [usize; 2] = [9, 10];
}

/// The sections of an object, in the order in which the trainer writes them.
pub const VIEWS_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && ViewsCounts::BYTES <= 4 * COUNTS);

/// What an object asks of its sections. Sizes: 1, K, V, W, E, L, N, M, T, texels, words of a mask of K bits, floats of a
/// view's deformation, N + L.
pub(crate) const RULES: [Rule; 16] = [
    Rule::new(SectionKind::ViewsCounts, ViewsCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [12, 0]).or_more(4),
    Rule::new(SectionKind::Maps, 4, [7, 0]),
    Rule::new(SectionKind::Layers, 12, [5, 0]),
    Rule::new(SectionKind::Vertices, 12, [2, 0]),
    Rule::floats(SectionKind::VertexWeights, 12, [3, 0]).floats_after(1),
    Rule::new(SectionKind::Elements, 8, [4, 0]),
    Rule::new(SectionKind::Neighbours, 8, [4, 0]),
    Rule::new(SectionKind::ViewTextures, 4, [6, 5]),
    Rule::floats(SectionKind::VertexTexels, 8, [6, 2]),
    Rule::floats(SectionKind::References, 8, [6, 1]),
    Rule::new(SectionKind::ViewMasks, 4, [6, 10]),
    Rule::new(SectionKind::Textures, 12, [8, 0]),
    Rule::new(SectionKind::Texels, 4, [9, 0]),
    Rule::floats(SectionKind::Deformations, 4, [6, 11]).with(OPTIONAL),
    Rule::floats(SectionKind::ViewsFit, ViewsFit::BYTES as u8, [0, 0]).unsigned(),
];
