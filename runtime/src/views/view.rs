//! An object in a loaded file, with access to its sections.

use super::counts::{CLIPS_MAX, NO_VERTEX, NOTHING, RULES, ViewsCounts, ViewsFit, mask_len};
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::{Le, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MAPS: usize = Rule::place(&RULES, SectionKind::Maps);
const LAYERS: usize = Rule::place(&RULES, SectionKind::Layers);
const VERTICES: usize = Rule::place(&RULES, SectionKind::Vertices);
const WEIGHTS: usize = Rule::place(&RULES, SectionKind::VertexWeights);
const ELEMENTS: usize = Rule::place(&RULES, SectionKind::Elements);
const NEIGHBOURS: usize = Rule::place(&RULES, SectionKind::Neighbours);
const VIEW_TEXTURES: usize = Rule::place(&RULES, SectionKind::ViewTextures);
const VERTEX_TEXELS: usize = Rule::place(&RULES, SectionKind::VertexTexels);
const REFERENCES: usize = Rule::place(&RULES, SectionKind::References);
const MASKS: usize = Rule::place(&RULES, SectionKind::ViewMasks);
const TEXTURES: usize = Rule::place(&RULES, SectionKind::Textures);
const TEXELS: usize = Rule::place(&RULES, SectionKind::Texels);
const DEFORMATIONS: usize = Rule::place(&RULES, SectionKind::Deformations);
const FIT: usize = Rule::place(&RULES, SectionKind::ViewsFit);

/// An element of an object: the numbers of its vertices, in the order of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// Has an affine texture map.
    Triangle([usize; 3]),
    /// Has a bilinear texture map.
    Quad([usize; 4]),
}

impl Element {
    /// Returns the numbers of its vertices.
    pub const fn vertices(&self) -> &[usize] {
        match self {
            Self::Triangle(vertices) => vertices,
            Self::Quad(vertices) => vertices,
        }
    }
}

/// A vertex of an object: a fixed place, plus the weighted sum of points.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    place: [f32; 2],
    weights: &'a [[Le; 3]],
}

impl<'a> Vertex<'a> {
    /// Returns the fixed place, without points.
    pub const fn place(&self) -> [f32; 2] {
        self.place
    }

    /// Lists the numbers of points, each with its weight. A weight is a complex number [a, b],
    /// which scales and rotates the point: x to a x - b y and y to b x + a y.
    pub fn weights(&self) -> impl Iterator<Item = (usize, [f32; 2])> + use<'a> {
        let pair = |[point, a, b]: &[Le; 3]| {
            (u32::from_le_bytes(*point) as usize, [*a, *b].map(f32::from_le_bytes))
        };
        self.weights.iter().map(pair)
    }

    /// Returns the point that equals this vertex, if there is one.
    pub fn point(&self) -> Option<usize> {
        let (point, weight) = self.weights().next().filter(|_| self.weights.len() == 1)?;
        (self.place == [0.0; 2] && weight == [1.0, 0.0]).then_some(point)
    }

    /// Returns the vertex's place and depth, from K points with depths.
    pub fn at(&self, points: &[[f32; 3]]) -> [f32; 3] {
        let [mut x, mut y] = self.place;
        let mut depth = 0.0;
        for (point, [a, b]) in self.weights() {
            let [px, py, pz] = points.get(point).copied().unwrap_or_default();
            (x, y) = (x + (a * px - b * py), y + (b * px + a * py));
            depth += a * pz;
        }
        [x, y, depth]
    }
}

/// A layer of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Number of the first element.
    pub first: usize,
    /// Number past the last element.
    pub end: usize,
    /// The layer that clips this layer: this layer is visible only where the clipping layer is
    /// opaque.
    pub clip: Option<usize>,
    /// Whether elements hide each other by depth, instead of in order.
    pub has_depth: bool,
    /// Whether the layer is drawn into its own buffer before blending, so that translucent elements
    /// may overlap.
    pub is_group: bool,
    /// Whether elements that turn anticlockwise on the screen are hidden.
    pub is_one_sided: bool,
}

impl Layer {
    /// Bytes of a row.
    pub const BYTES: usize = 12;
    /// Flag bit of a layer with depth.
    pub const DEPTH: u32 = 1;
    /// Flag bit of a group.
    pub const GROUP: u32 = 2;
    /// Flag bit of a one-sided layer.
    pub const ONE_SIDED: u32 = 4;
    /// All flag bits.
    pub(super) const FLAGS: u32 = Self::DEPTH | Self::GROUP | Self::ONE_SIDED;
}

/// A picture of RGBA8 texels in sRGB with straight alpha, row by row from the top.
#[derive(Clone, Copy, Debug, Default)]
pub struct Texture<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: &'a [[u8; 4]],
}

impl<'a> Texture<'a> {
    /// Returns width and height in texels.
    pub const fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Returns the texels.
    pub const fn texels(&self) -> &'a [[u8; 4]] {
        self.texels
    }
}

/// An object of K control points in L layers, seen in N key views; borrowed from a loaded model.
///
/// Accessors by number return `None` if the number is out of range.
#[derive(Clone, Copy)]
pub struct Views<'a>(pub(crate) Part<'a>);

part::view! { Views, Views, |words| -> ViewsCounts { ViewsCounts::from_words(first_counts(words)) } }

impl<'a> Views<'a> {
    /// Returns K, the number of control points.
    pub const fn point_len(&self) -> usize {
        self.counts().point_len as usize
    }

    /// Returns V, the number of vertices.
    pub const fn vertex_len(&self) -> usize {
        self.counts().vertex_len as usize
    }

    /// Returns E, the number of elements.
    pub const fn element_len(&self) -> usize {
        self.counts().element_len as usize
    }

    /// Returns L, the number of layers.
    pub const fn layer_len(&self) -> usize {
        self.counts().layer_len as usize
    }

    /// Returns width and height of the screen of the points, in pixels.
    pub const fn size(&self) -> [usize; 2] {
        let [width, height] = self.counts().size;
        [width as usize, height as usize]
    }

    /// Returns N, the number of key views.
    pub const fn view_len(&self) -> usize {
        self.counts().view_len as usize
    }

    /// Returns a key view's name.
    pub fn view_name(&self, view: usize) -> Option<&'a str> {
        self.names().get(view.checked_add(1)?).filter(|_| view < self.view_len())
    }

    /// Returns a layer's name.
    pub fn layer_name(&self, layer: usize) -> Option<&'a str> {
        let place = layer.checked_add(self.view_len())?.checked_add(1)?;
        self.names().get(place).filter(|_| layer < self.layer_len())
    }

    /// Returns the row of a map's kernel in the part table; [`crate::Model::map_of`] returns the
    /// kernel itself.
    pub fn map_part(&self, map: usize) -> Option<usize> {
        let [part] = self.0.entry(MAPS, self.counts().map_len as usize, map)?;
        Some(u32::from_le_bytes(*part) as usize)
    }

    /// Returns a layer. Layers are drawn in the order of the file unless maps give another order.
    pub fn layer(&self, layer: usize) -> Option<Layer> {
        let rows = self.layers();
        let [end, clip, flags] = rows.get(layer)?.map(u32::from_le_bytes);
        let before = layer.checked_sub(1).and_then(|before| rows.get(before));
        let first = before.map_or(0, |[end, ..]| u32::from_le_bytes(*end));
        Some(Layer {
            first: first as usize,
            end: end as usize,
            clip: (clip != NOTHING).then_some(clip as usize),
            has_depth: flags & Layer::DEPTH != 0,
            is_group: flags & Layer::GROUP != 0,
            is_one_sided: flags & Layer::ONE_SIDED != 0,
        })
    }

    /// Whether a layer has depth.
    pub fn has_depth(&self) -> bool {
        (0..).map_while(|layer| self.layer(layer)).any(|layer| layer.has_depth)
    }

    /// Whether a layer is clipped by another.
    pub fn has_clips(&self) -> bool {
        (0..).map_while(|layer| self.layer(layer)).any(|layer| layer.clip.is_some())
    }

    /// Whether a layer is a group or clipped, and therefore drawn into its own buffer.
    pub fn has_groups(&self) -> bool {
        let mut layers = (0..).map_while(|layer| self.layer(layer));
        layers.any(|layer| layer.is_group || layer.clip.is_some())
    }

    /// Returns E + L, the length of the scratch for sorting in `RenderJob::run`.
    pub const fn order_len(&self) -> usize {
        self.element_len().saturating_add(self.layer_len())
    }

    /// Lists the layers that clip a layer: the layer of its row, the layer that clips that layer,
    /// and so on, at most [`CLIPS_MAX`].
    pub fn clips(&self, layer: usize) -> impl Iterator<Item = usize> + use<'a> {
        // Bytes that changed after loading may hold a circle.
        self.chain(layer).take(CLIPS_MAX)
    }

    /// Lists the layers that clip a layer; endless for a circle.
    pub(super) fn chain(&self, layer: usize) -> impl Iterator<Item = usize> + use<'a> {
        let own = *self;
        let next = move |layer: &usize| own.layer(*layer).and_then(|layer| layer.clip);
        core::iter::successors(next(&layer), next)
    }

    /// Returns a vertex.
    pub fn vertex(&self, vertex: usize) -> Option<Vertex<'a>> {
        let rows = self.vertices();
        let [end, x, y] = rows.get(vertex)?;
        let before = vertex.checked_sub(1).and_then(|before| rows.get(before));
        let first = before.map_or(0, |[end, ..]| u32::from_le_bytes(*end) as usize);
        let end = u32::from_le_bytes(*end) as usize;
        let weights = self.weights().get(first..end).unwrap_or_default();
        Some(Vertex { place: [*x, *y].map(f32::from_le_bytes), weights })
    }

    /// Returns an element. Elements of a layer are drawn in order unless depths decide.
    pub fn element(&self, element: usize) -> Option<Element> {
        let vertices = self.elements().get(element).filter(|_| element < self.element_len())?;
        let [a, b, c, d] = vertices.map(|le| usize::from(u16::from_le_bytes(le)));
        Some(if d == NO_VERTEX.into() {
            Element::Triangle([a, b, c])
        } else {
            Element::Quad([a, b, c, d])
        })
    }

    /// Returns the elements across the edges of an element, starting with the edge between its
    /// first two vertices; `None` across a border.
    pub fn neighbours(&self, element: usize) -> Option<[Option<usize>; 4]> {
        let own = self.neighbour_rows().get(element).filter(|_| element < self.element_len())?;
        let own = own.map(u16::from_le_bytes);
        Some(own.map(|other| (other != NO_VERTEX).then_some(other.into())))
    }

    /// Returns the number of a layer's texture in a key view; `None` if the view does not show the
    /// layer.
    pub fn view_texture(&self, view: usize, layer: usize) -> Option<usize> {
        let place = view.checked_mul(self.layer_len())?.checked_add(layer)?;
        let is_there = view < self.view_len() && layer < self.layer_len();
        let texture = self.view_textures().get(place).filter(|_| is_there)?;
        let texture = u32::from_le_bytes(*texture);
        (texture != NOTHING).then_some(texture as usize)
    }

    /// Returns the place of a vertex in its layer's texture of a key view, in texels: x to the
    /// right, y down, centres at 0.5.
    pub fn texel(&self, view: usize, vertex: usize) -> Option<[f32; 2]> {
        self.row(VERTEX_TEXELS, view, self.vertex_len()).get(vertex).map(floats)
    }

    /// Returns the place of a point on the screen in a key view, in pixels.
    pub fn reference(&self, view: usize, point: usize) -> Option<[f32; 2]> {
        self.row(REFERENCES, view, self.point_len()).get(point).map(floats)
    }

    /// Whether a point is visible in a key view.
    pub fn is_visible(&self, view: usize, point: usize) -> Option<bool> {
        let words = mask_len(self.counts().point_len) as usize;
        let mask: &[Le] = self.0.bytes(MASKS).as_chunks().0;
        let word = mask.get(view.checked_mul(words)?.checked_add(point / 32)?)?;
        let is_there = view < self.view_len() && point < self.point_len();
        is_there.then_some(u32::from_le_bytes(*word) >> (point % 32) & 1 == 1)
    }

    /// Returns a texture.
    pub fn texture(&self, texture: usize) -> Option<Texture<'a>> {
        let row = self.0.entry(TEXTURES, self.counts().texture_len as usize, texture)?;
        let [width, height, start] = row.map(|le| u32::from_le_bytes(le) as usize);
        let texels = self.texels().get(start..)?.get(..width.checked_mul(height)?)?;
        Some(Texture { width, height, texels })
    }

    /// Whether the object takes its motion from another object, its prototype (METHOD §6.6).
    pub const fn is_transferred(&self) -> bool {
        self.0.layout.has(DEFORMATIONS)
    }

    /// Returns s of a key view, the scale of the prototype's motion; `None` if the object is not
    /// transferred.
    pub fn ratio(&self, view: usize) -> Option<f32> {
        self.deformation(view).map(|(ratio, _)| ratio)
    }

    /// Returns `R' - s R` of a point in a key view, in pixels of the screen. R is the centred
    /// reference of the prototype, and R' of this object. `None` if the object is not transferred.
    pub fn offset(&self, view: usize, point: usize) -> Option<[f32; 2]> {
        self.deformation(view)?.1.get(point).map(floats)
    }

    /// Returns the measured accuracy of the object.
    pub fn fit(&self) -> ViewsFit {
        let figures = self.0.array(FIT).first().map(floats);
        ViewsFit::from_figures(figures.unwrap_or_default())
    }

    pub(super) fn names(&self) -> Names<'a> {
        let named = self.view_len().saturating_add(self.layer_len());
        Names::new(self.0.bytes(NAMES), named.saturating_add(1))
    }

    pub(super) fn maps(&self) -> &'a [Le] {
        self.0.bytes(MAPS).as_chunks().0
    }

    pub(super) fn layers(&self) -> &'a [[Le; 3]] {
        self.0.array(LAYERS)
    }

    pub(super) fn vertices(&self) -> &'a [[Le; 3]] {
        self.0.array(VERTICES)
    }

    pub(super) fn weights(&self) -> &'a [[Le; 3]] {
        self.0.array(WEIGHTS)
    }

    pub(super) fn elements(&self) -> &'a [[[u8; 2]; 4]] {
        self.0.bytes(ELEMENTS).as_chunks().0.as_chunks().0
    }

    pub(super) fn neighbour_rows(&self) -> &'a [[[u8; 2]; 4]] {
        self.0.bytes(NEIGHBOURS).as_chunks().0.as_chunks().0
    }

    pub(super) fn view_textures(&self) -> &'a [Le] {
        self.0.bytes(VIEW_TEXTURES).as_chunks().0
    }

    pub(super) fn masks(&self) -> &'a [Le] {
        self.0.bytes(MASKS).as_chunks().0
    }

    pub(super) fn textures(&self) -> &'a [[Le; 3]] {
        self.0.array(TEXTURES)
    }

    fn texels(&self) -> &'a [[u8; 4]] {
        self.0.bytes(TEXELS).as_chunks().0
    }

    /// Returns the `len` places of a key view from a section with `len` places per view.
    fn row(&self, section: usize, view: usize, len: usize) -> &'a [[Le; 2]] {
        if view >= self.view_len() {
            return &[];
        }
        // A chunk length of zero would panic.
        self.0.array(section).chunks_exact(len.max(1)).nth(view).unwrap_or_default()
    }

    /// Returns s of a key view, and its K offsets.
    pub(super) fn deformation(&self, view: usize) -> Option<(f32, &'a [[Le; 2]])> {
        let words: &[Le] = self.0.bytes(DEFORMATIONS).as_chunks().0;
        // A chunk length of zero would panic, which also covers a product that wraps.
        let mut views = words.chunks_exact((2 * self.point_len() + 1).max(1));
        let (ratio, offsets) = views.nth(view).filter(|_| view < self.view_len())?.split_first()?;
        Some((f32::from_le_bytes(*ratio), offsets.as_chunks().0))
    }
}
