//! Counts and measured accuracy of an object.

use crate::format::SectionKind;
use crate::format::flat::flat;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};

/// Sentinel for "none": for the fourth vertex and neighbour of a triangle, and for the neighbour
/// across a border.
pub const NO_VERTEX: u16 = u16::MAX;
/// Sentinel for "none": for the texture of a layer in a key view, and for the layer that clips a
/// layer.
pub const NOTHING: u32 = u32::MAX;

/// Largest number of layers that clip one layer, including the layers that clip its clipping
/// layers.
pub const CLIPS_MAX: usize = 8;
/// Largest number of elements in clipping layers. A layer's elements count once for every layer
/// that it clips.
pub const CLIP_ELEMENTS_MAX: usize = 1 << 20;
/// Largest product of elements and key views. Elements of clipping layers count again, as for
/// [`CLIP_ELEMENTS_MAX`]. The raster compares each element with each key view.
pub const FITS_MAX: usize = 1 << 22;

/// Counts of an object. The length of every section follows from the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewsCounts {
    /// Control points, K.
    pub point_len: u32,
    /// Vertices, V.
    pub vertex_len: u32,
    /// Weights of points for vertices, W.
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
    /// Width and height of the screen of the points, in pixels.
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

    /// Makes the counts from their words.
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

    /// Returns the numbers in a result of a map: K places with depth, K visibilities, N scores, and
    /// opacity and order of L layers.
    pub const fn result_len(&self) -> usize {
        let points = (self.point_len as usize).saturating_mul(4);
        let layers = (self.layer_len as usize).saturating_mul(2);
        points.saturating_add(self.view_len as usize).saturating_add(layers)
    }

    /// Computes a section's length in bytes, or the least length of the names; `None` if objects
    /// lack the section.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the requirements for the sections, in the terms of [`RULES`].
    pub(crate) const fn asked(&self) -> Asked {
        let Self { point_len: k, vertex_len: v, weight_len: w, element_len: e, .. } = *self;
        let Self { layer_len: l, view_len: n, map_len: m, texture_len: t, texel_len, .. } = *self;
        let deformation = k.saturating_mul(2).saturating_add(1);
        let named = n.saturating_add(l);
        Asked::new(ALWAYS, [1, k, v, w, e, l, n, m, t, texel_len, mask_len(k), deformation, named])
    }
}

/// Returns the words of a mask with one bit per point.
pub(crate) const fn mask_len(point_len: u32) -> u32 {
    point_len.div_ceil(32)
}

/// Measured accuracy of an object. Lengths are in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct ViewsFit {
    /// RMS distance between the examples' points and the maps' points, over points and examples.
    pub rms_error: f32,
    /// RMS distance with each example left out of its own fit; 0 if not measured.
    pub left_out_rms: f32,
    /// Share of the points with correct visibility.
    pub visibility: f32,
}

flat! { ViewsFit of "views_fit", figures, from_figures: [f32; 3] {
    rms_error, left_out_rms, visibility
} }

/// Indices of the counts in their section.
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

/// The sections of an object, in the trainer's order.
pub const VIEWS_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && ViewsCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of an object. Sizes: 1, K, V, W, E, L, N, M, T, texels, words of a mask
/// of K bits, floats of a view's deformation, N + L.
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
