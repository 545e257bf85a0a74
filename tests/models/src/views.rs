//! Objects of key views as plain lists, whose fields may be invalid.

use crate::bytes::{floats, halves, names, words};
use crate::kernels::KernelContent;
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::kernel::{Kernel, NO_TERM, OutputKind, OutputRow};
use sinew_runtime::views::{Layer, NO_VERTEX, NOTHING, VIEWS_SECTIONS};

/// An object of key views as plain lists.
#[derive(Clone)]
pub struct ViewsContent {
    /// Name of the part.
    pub name: String,
    /// Parts of its M maps.
    pub maps: Vec<u32>,
    /// Number of points K.
    pub point_len: usize,
    /// Width and height of the screen, in pixels.
    pub size: [u32; 2],
    /// V vertices.
    pub vertices: Vec<VertexContent>,
    /// L layers.
    pub layers: Vec<LayerContent>,
    /// N key views.
    pub views: Vec<ViewContent>,
    /// T textures.
    pub textures: Vec<TextureContent>,
    /// RMS error, RMS error of left-out views, share of points with the visibility of the examples.
    pub fit: [f32; 3],
}

/// A vertex: its fixed place, and its points by number with a weight each.
pub type VertexContent = ([f32; 2], Vec<(u32, [f32; 2])>);

/// A layer as plain lists.
#[derive(Clone)]
pub struct LayerContent {
    /// Name of the layer.
    pub name: String,
    /// Elements: vertices; triangles have [`NO_VERTEX`] last.
    pub elements: Vec<[u16; 4]>,
    /// For each element, the elements across its edges.
    pub neighbours: Vec<[u16; 4]>,
    /// The layer that clips this layer; [`NOTHING`] if none does.
    pub clip: u32,
    /// [`sinew_runtime::views::Layer::DEPTH`], or 0.
    pub flags: u32,
}

/// A key view as plain lists.
#[derive(Clone)]
pub struct ViewContent {
    /// Name of the key view.
    pub name: String,
    /// L textures; [`NOTHING`] for a missing layer.
    pub textures: Vec<u32>,
    /// V places in the textures.
    pub texels: Vec<[f32; 2]>,
    /// K places on the screen.
    pub references: Vec<[f32; 2]>,
    /// K visibilities.
    pub visible: Vec<bool>,
    /// s and K offsets; `None` unless the object is transferred.
    pub deformation: Option<(f32, Vec<[f32; 2]>)>,
}

/// A texture as plain lists.
#[derive(Clone)]
pub struct TextureContent {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Texels, row by row from the top.
    pub texels: Vec<[u8; 4]>,
}

/// Points per side of the sample's grid.
const SIDE: usize = 3;
/// Points of the sample.
const POINTS: usize = SIDE * SIDE;
/// Key views of the sample.
const VIEWS: usize = 3;
/// Layers of the sample.
const LAYERS: usize = 2;

impl ViewsContent {
    /// Makes an object of a grid of 3 x 3 points on a screen of 48 x 40 pixels. The first layer has
    /// two quads and four triangles. The second layer, clipped by the first, is a triangle whose
    /// third vertex depends on three points. Of three key views, the second lacks the second layer.
    /// There are two textures.
    pub fn sample(maps: Vec<u32>, is_transferred: bool) -> Self {
        let mut rng = Rng(50);
        let sizes = [[12, 10], [7, 9]];
        let textures: Vec<_> = sizes.map(|size| TextureContent::sample(&mut rng, size)).into();
        let view = |(view, name): (usize, &str)| {
            let texture = view % 2;
            let [width, height] = sizes[texture].map(|x| x as f32);
            let texels = grid()
                .chain([[1.5, 1.25]])
                .map(|[x, y]| [width * (x + 0.25) / 2.5, height * (y + 0.25) / 2.5]);
            let hidden = [POINTS, 8, 0][view];
            let offsets = (0..POINTS).map(|_| [2.0 * rng.unit(), 2.0 * rng.unit()]).collect();
            ViewContent {
                name: name.to_owned(),
                textures: vec![texture as u32, if view == 1 { NOTHING } else { 1 }],
                texels: texels.collect(),
                references: grid().map(|[x, y]| [12.0 * x + view as f32, 10.0 * y + 3.0]).collect(),
                visible: (0..POINTS).map(|point| point != hidden).collect(),
                deformation: is_transferred.then_some(([1.0, 1.25, 0.75][view], offsets)),
            }
        };
        let triangle = |a, b, c| [a, b, c, NO_VERTEX];
        let body = LayerContent {
            name: "body".to_owned(),
            elements: vec![
                [0, 1, 4, 3],
                triangle(1, 2, 5),
                triangle(1, 5, 4),
                triangle(3, 4, 7),
                triangle(7, 6, 3),
                [4, 5, 8, 7],
            ],
            neighbours: Vec::new(),
            clip: NOTHING,
            flags: 0,
        };
        let mark = LayerContent {
            name: "mark".to_owned(),
            elements: vec![triangle(4, 5, 9)],
            neighbours: Vec::new(),
            clip: 0,
            flags: Layer::GROUP,
        };
        let point = |point| ([0.0; 2], vec![(point, [1.0, 0.0])]);
        let mut out = Self {
            name: "object".to_owned(),
            maps,
            point_len: POINTS,
            size: [48, 40],
            vertices: (0..POINTS as u32)
                .map(point)
                .chain([(
                    [0.5, -0.25],
                    vec![(5, [0.75, 0.0]), (7, [0.5, 0.125]), (4, [-0.25, -0.125])],
                )])
                .collect(),
            layers: vec![body, mark],
            views: ["left", "front", "right"].into_iter().enumerate().map(view).collect(),
            textures,
            fit: [0.0625, 0.125, 0.875],
        };
        out.meet();
        out
    }

    /// Makes an object of one layer, whose vertices are its points. Every key view shows the points
    /// as given.
    pub fn plain(
        elements: Vec<[u16; 4]>,
        views: Vec<ViewContent>,
        texture: TextureContent,
    ) -> Self {
        let point_len = views.first().map_or(0, |view| view.visible.len());
        let mut out = Self {
            name: "object".to_owned(),
            maps: vec![0],
            point_len,
            size: [texture.width, texture.height],
            vertices: (0..point_len as u32)
                .map(|point| ([0.0; 2], vec![(point, [1.0, 0.0])]))
                .collect(),
            layers: vec![LayerContent {
                name: "object".to_owned(),
                elements,
                neighbours: Vec::new(),
                clip: NOTHING,
                flags: 0,
            }],
            views,
            textures: vec![texture],
            fit: [0.0, 0.0, 1.0],
        };
        out.meet();
        out
    }

    /// Finds the neighbours of all elements.
    pub fn meet(&mut self) {
        let mut first = 0;
        for layer in &mut self.layers {
            let edges: Vec<Vec<[u16; 2]>> = layer.elements.iter().map(edges).collect();
            let across = |element: usize, edge: &[u16; 2]| {
                let [a, b] = *edge;
                let other = edges.iter().enumerate().find(|(other, edges)| {
                    *other != element && (edges.contains(&[a, b]) || edges.contains(&[b, a]))
                });
                other.map_or(NO_VERTEX, |(other, _)| (first + other) as u16)
            };
            let row = |(element, own): (usize, &Vec<[u16; 2]>)| {
                let mut row = [NO_VERTEX; 4];
                row.iter_mut().zip(own).for_each(|(out, edge)| *out = across(element, edge));
                row
            };
            layer.neighbours = edges.iter().enumerate().map(row).collect();
            first += layer.elements.len();
        }
    }

    /// Writes the sections that the object needs.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    fn sections(&self) -> Vec<(SectionKind, Vec<u8>)> {
        let views = &self.views;
        let elements: Vec<_> = self.layers.iter().flat_map(|layer| &layer.elements).collect();
        let neighbours = self.layers.iter().flat_map(|layer| layer.neighbours.clone());
        let neighbours: Vec<_> = neighbours.collect();
        let texels: Vec<_> = self.textures.iter().flat_map(|texture| &texture.texels).collect();
        let weights: Vec<_> = self.vertices.iter().flat_map(|(_, weights)| weights).collect();
        let counts = [
            self.point_len,
            self.vertices.len(),
            weights.len(),
            elements.len(),
            self.layers.len(),
            views.len(),
            self.maps.len(),
            self.textures.len(),
            texels.len(),
        ];
        let counts = counts.map(|len| len as u32);
        let counts = [&counts[..], &self.size].concat();
        let names_of_views = views.iter().map(|view| view.name.clone());
        let names_of_layers = self.layers.iter().map(|layer| layer.name.clone());
        let all_names: Vec<_> = names_of_views.chain(names_of_layers).collect();
        let sums = |lens: Vec<usize>| -> Vec<u32> {
            let add = |sum: &mut u32, len: usize| {
                *sum += len as u32;
                Some(*sum)
            };
            lens.into_iter().scan(0, add).collect()
        };
        let layer_ends = sums(self.layers.iter().map(|layer| layer.elements.len()).collect());
        let layers = self.layers.iter().zip(layer_ends);
        let layers: Vec<_> =
            layers.flat_map(|(layer, end)| [end, layer.clip, layer.flags]).collect();
        let vertex_ends = sums(self.vertices.iter().map(|(_, weights)| weights.len()).collect());
        let vertices = self.vertices.iter().zip(vertex_ends);
        let vertices = vertices.flat_map(|(([x, y], _), end)| [end, x.to_bits(), y.to_bits()]);
        let vertices: Vec<_> = vertices.collect();
        let weight_rows =
            weights.iter().flat_map(|(point, [a, b])| [*point, a.to_bits(), b.to_bits()]);
        let weight_rows: Vec<_> = weight_rows.collect();
        let mut start = 0;
        let rows = self.textures.iter().flat_map(|texture| {
            let row = [texture.width, texture.height, start];
            start += texture.texels.len() as u32;
            row
        });
        let rows: Vec<_> = rows.collect();
        let masks: Vec<_> = views.iter().flat_map(|view| mask(&view.visible)).collect();
        let deformations: Option<Vec<_>> = views
            .iter()
            .map(|view| {
                let (ratio, offsets) = view.deformation.as_ref()?;
                Some([&[*ratio], offsets.as_flattened()].concat())
            })
            .collect();
        let references: Vec<_> = views.iter().flat_map(|view| view.references.clone()).collect();
        let vertex_texels: Vec<_> = views.iter().flat_map(|view| view.texels.clone()).collect();
        let view_textures: Vec<_> =
            views.iter().flat_map(|view| view.textures.iter().copied()).collect();
        let flat = |rows: Vec<[u16; 4]>| halves(rows.as_flattened());
        let written = [
            (SectionKind::ViewsCounts, Some(words(&counts))),
            (SectionKind::Names, Some(names(&self.name, &all_names))),
            (SectionKind::Maps, Some(words(&self.maps))),
            (SectionKind::Layers, Some(words(&layers))),
            (SectionKind::Vertices, Some(words(&vertices))),
            (SectionKind::VertexWeights, Some(words(&weight_rows))),
            (SectionKind::Elements, Some(flat(elements.into_iter().copied().collect()))),
            (SectionKind::Neighbours, Some(flat(neighbours))),
            (SectionKind::ViewTextures, Some(words(&view_textures))),
            (SectionKind::VertexTexels, Some(floats(vertex_texels.as_flattened()))),
            (SectionKind::References, Some(floats(references.as_flattened()))),
            (SectionKind::ViewMasks, Some(words(&masks))),
            (SectionKind::Textures, Some(words(&rows))),
            (SectionKind::Texels, Some(texels.into_iter().flatten().copied().collect())),
            (SectionKind::Deformations, deformations.map(|all| floats(&all.concat()))),
            (SectionKind::ViewsFit, Some(floats(&self.fit))),
        ];
        assert!(written.iter().map(|(kind, _)| *kind).eq(VIEWS_SECTIONS));
        written.into_iter().filter_map(|(kind, bytes)| Some((kind, bytes?))).collect()
    }
}

impl TextureContent {
    fn sample(rng: &mut Rng, [width, height]: [u32; 2]) -> Self {
        let mut byte = || (rng.next_u64() >> 56) as u8;
        let texel = |_| [byte(), byte(), byte(), byte() | 64];
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }
}

impl KernelContent {
    /// Makes a map of [`ViewsContent::sample`] from two numbers to 9 places with depths, 9
    /// visibilities, 3 scores, 2 opacities and 2 orders.
    pub fn map(name: &str, seed: u64) -> Self {
        let mut rng = Rng(seed);
        let m = 4 * POINTS + VIEWS + 2 * LAYERS;
        let plain = Self::plain(Kernel::Gaussian, [2, 6, m]);
        // Mean of a value, its slope by each number, and the size of the kernels' contribution.
        let grid: Vec<_> = grid().collect();
        let row = |value: usize| match (value / 3, value % 3) {
            (point, 0) if point < POINTS => (8.0 + 16.0 * grid[point][0], [2.0, 0.5], 2.0),
            (point, 1) if point < POINTS => (5.0 + 15.0 * grid[point][1], [-0.5, 1.5], 2.0),
            (point, _) if point < POINTS => (grid[point][0] - 1.0, [-1.0, 0.25], 0.5),
            _ if value < 4 * POINTS => (0.875, [0.0, 0.125], 0.25),
            _ if value < 4 * POINTS + VIEWS => {
                (0.0, [(value - 4 * POINTS) as f32 - 1.0, 0.125], 0.25)
            }
            _ if value < 4 * POINTS + VIEWS + LAYERS => (0.75, [0.25, 0.0], 0.0),
            _ => ((value - 4 * POINTS - VIEWS - LAYERS) as f32, [0.0; 2], 0.0),
        };
        let coefficients = (0..m).map(|value| {
            let (about, turns, moves) = row(value);
            let centres = (0..6).map(|_| moves * rng.unit()).collect::<Vec<_>>();
            [centres.as_slice(), &[about], &turns].concat()
        });
        let coefficients = coefficients.collect();
        let free = plain.outputs[0].1;
        let place =
            OutputRow { kind: OutputKind::Vector3, range: (0.0, 0.0), neutral: [0.0; 4], ..free };
        let places = (0..POINTS).map(|point| (format!("point {point}"), place));
        let numbers =
            (0..POINTS + VIEWS + 2 * LAYERS).map(|number| (format!("number {number}"), free));
        Self {
            name: name.to_owned(),
            outputs: places.chain(numbers).collect(),
            terms: vec![[NO_TERM; 2], [0, 0], [0, 1]],
            coefficients,
            ..plain
        }
    }
}

impl Pieces {
    /// Appends an object of key views.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn add_views(&mut self, content: &ViewsContent) {
        let part = self.parts.len() as u16;
        self.parts.push(PartRow { kind: PartKind::Views.number(), flags: 1 });
        let own = content.sections().into_iter();
        self.sections.extend(own.map(|(kind, bytes)| Content::new(kind, part, bytes)));
    }

    /// Makes two files: an object with two maps that is not transferred, and a transferred object
    /// with one map.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn viewed() -> [Self; 2] {
        [false, true].map(|is_transferred| {
            let maps = if is_transferred { &["walk"][..] } else { &["walk", "jump"] };
            let kernels: Vec<_> =
                maps.iter().zip(51..).map(|(name, seed)| KernelContent::map(name, seed)).collect();
            let mut pieces = Self::kernels(&kernels);
            let maps = (0..kernels.len() as u32).collect();
            let mut content = ViewsContent::sample(maps, is_transferred);
            if is_transferred {
                content.layers[0].flags = Layer::DEPTH | Layer::ONE_SIDED;
            }
            pieces.add_views(&content);
            pieces
        })
    }
}

/// Names of the golden objects, which [`Pieces::viewed`] makes.
pub const VIEWED_NAMES: [&str; 2] = ["views-11.snw", "views-11-transferred.snw"];

/// Lists the edges of an element by their vertices.
fn edges(element: &[u16; 4]) -> Vec<[u16; 2]> {
    let own: Vec<u16> = element.iter().copied().filter(|vertex| *vertex != NO_VERTEX).collect();
    let ends = own.iter().cycle().skip(1);
    own.iter().zip(ends).map(|(a, b)| [*a, *b]).collect()
}

/// Lists the places of a grid, row by row.
fn grid() -> impl Iterator<Item = [f32; 2]> {
    (0..POINTS).map(|point| [(point % SIDE) as f32, (point / SIDE) as f32])
}

/// Packs bits into words.
fn mask(bits: &[bool]) -> Vec<u32> {
    let word = |bits: &[bool]| bits.iter().rev().fold(0, |word, bit| word << 1 | u32::from(*bit));
    bits.chunks(32).map(word).collect()
}
