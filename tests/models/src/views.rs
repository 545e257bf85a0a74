//! Objects of key views in plain lists, each field free to be wrong.

use crate::bytes::{floats, halves, names, words};
use crate::kernels::KernelContent;
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::kernel::{Kernel, NO_TERM, OutputKind, OutputRow};
use sinew_runtime::views::{NO_POINT, VIEWS_SECTIONS};

/// An object of key views in plain lists.
#[derive(Clone)]
pub struct ViewsContent {
    /// Name of the part.
    pub name: String,
    /// M: parts that are its maps.
    pub maps: Vec<u32>,
    /// K.
    pub point_len: usize,
    /// E: points, of a triangle [`NO_POINT`] last.
    pub elements: Vec<[u16; 4]>,
    /// N.
    pub views: Vec<ViewContent>,
    /// T.
    pub textures: Vec<TextureContent>,
    /// Margin, RMS error, the same left out, visibility.
    pub fit: [f32; 4],
}

/// A key view in plain lists.
#[derive(Clone)]
pub struct ViewContent {
    /// Its name.
    pub name: String,
    /// Its texture.
    pub texture: u32,
    /// K places in the texture.
    pub references: Vec<[f32; 2]>,
    /// K.
    pub visible: Vec<bool>,
    /// s, and K offsets; of an object that is not transferred none.
    pub deformation: Option<(f32, Vec<[f32; 2]>)>,
}

/// A texture in plain lists.
#[derive(Clone)]
pub struct TextureContent {
    /// Texels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top.
    pub texels: Vec<[u8; 4]>,
}

/// Points of a side of the sample's grid.
const SIDE: usize = 3;
/// Points of the sample.
const POINTS: usize = SIDE * SIDE;
/// Key views of the sample.
const VIEWS: usize = 3;

impl ViewsContent {
    /// Makes an object of a grid of 3 x 3 points about a screen of 48 x 40 pixels: two quads, four triangles, three key
    /// views, two textures.
    pub fn sample(maps: Vec<u32>, is_transferred: bool) -> Self {
        let mut rng = Rng(50);
        let sizes = [[12, 10], [7, 9]];
        let textures: Vec<_> = sizes.map(|size| TextureContent::sample(&mut rng, size)).into();
        let view = |(view, name): (usize, &str)| {
            let texture = view % 2;
            let [width, height] = sizes[texture].map(|x| x as f32);
            let references =
                grid().map(|[x, y]| [width * (x + 0.25) / 2.5, height * (y + 0.25) / 2.5]);
            let hidden = [POINTS, 8, 0][view];
            let offsets = (0..POINTS).map(|_| [2.0 * rng.unit(), 2.0 * rng.unit()]).collect();
            ViewContent {
                name: name.to_owned(),
                texture: texture as u32,
                references: references.collect(),
                visible: (0..POINTS).map(|point| point != hidden).collect(),
                deformation: is_transferred.then_some(([1.0, 1.25, 0.75][view], offsets)),
            }
        };
        let triangle = |a, b, c| [a, b, c, NO_POINT];
        Self {
            name: "object".to_owned(),
            maps,
            point_len: POINTS,
            elements: vec![
                [0, 1, 4, 3],
                triangle(1, 2, 5),
                triangle(1, 5, 4),
                triangle(3, 4, 7),
                triangle(7, 6, 3),
                [4, 5, 8, 7],
            ],
            views: ["left", "front", "right"].into_iter().enumerate().map(view).collect(),
            textures,
            fit: [0.25, 0.0625, 0.125, 0.875],
        }
    }

    /// Writes the sections, those that there are.
    ///
    /// # Panics
    /// If the order of sections is no longer FORMAT.md's.
    fn sections(&self) -> Vec<(SectionKind, Vec<u8>)> {
        let views = &self.views;
        let lens = [self.point_len, self.elements.len(), views.len(), self.maps.len()];
        let texels: Vec<_> = self.textures.iter().flat_map(|texture| &texture.texels).collect();
        let counts = lens.into_iter().chain([self.textures.len(), texels.len()]);
        let counts: Vec<_> = counts.map(|len| len as u32).collect();
        let view_names: Vec<_> = views.iter().map(|view| view.name.clone()).collect();
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
        let view_textures: Vec<_> = views.iter().map(|view| view.texture).collect();
        let written = [
            (SectionKind::ViewsCounts, Some(words(&counts))),
            (SectionKind::Names, Some(names(&self.name, &view_names))),
            (SectionKind::Maps, Some(words(&self.maps))),
            (SectionKind::Elements, Some(halves(self.elements.as_flattened()))),
            (SectionKind::ViewTextures, Some(words(&view_textures))),
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
    /// Makes a map of [`ViewsContent::sample`]: two numbers to 9 places with depths, 9 visibilities and 3 scores.
    pub fn map(name: &str, seed: u64) -> Self {
        let mut rng = Rng(seed);
        let m = 4 * POINTS + VIEWS;
        let plain = Self::plain(Kernel::Gaussian, [2, 6, m]);
        // What a value is about, what turns it with either number, and by how much centres move it.
        let grid: Vec<_> = grid().collect();
        let row = |value: usize| match (value / 3, value % 3) {
            (point, 0) if point < POINTS => (8.0 + 16.0 * grid[point][0], [2.0, 0.5], 2.0),
            (point, 1) if point < POINTS => (5.0 + 15.0 * grid[point][1], [-0.5, 1.5], 2.0),
            (point, _) if point < POINTS => (grid[point][0] - 1.0, [-1.0, 0.25], 0.5),
            _ if value < 4 * POINTS => (0.875, [0.0, 0.125], 0.25),
            _ => (0.0, [(value - 4 * POINTS) as f32 - 1.0, 0.125], 0.25),
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
        let numbers = (0..POINTS + VIEWS).map(|number| (format!("number {number}"), free));
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
    /// If the order of sections is no longer FORMAT.md's.
    pub fn add_views(&mut self, content: &ViewsContent) {
        let part = self.parts.len() as u16;
        self.parts.push(PartRow { kind: PartKind::Views.number(), flags: 1 });
        let own = content.sections().into_iter();
        self.sections.extend(own.map(|(kind, bytes)| Content::new(kind, part, bytes)));
    }

    /// Makes a file of an object with two maps, which stands alone, and of one with a map that is transferred.
    ///
    /// # Panics
    /// If the order of sections is no longer FORMAT.md's.
    pub fn viewed() -> [Self; 2] {
        [false, true].map(|is_transferred| {
            let maps = if is_transferred { &["walk"][..] } else { &["walk", "jump"] };
            let kernels: Vec<_> =
                maps.iter().zip(51..).map(|(name, seed)| KernelContent::map(name, seed)).collect();
            let mut pieces = Self::kernels(&kernels);
            let maps = (0..kernels.len() as u32).collect();
            pieces.add_views(&ViewsContent::sample(maps, is_transferred));
            pieces
        })
    }
}

/// The golden files of objects, as [`Pieces::viewed`] makes them.
pub const VIEWED_NAMES: [&str; 2] = ["views-7.snw", "views-7-transferred.snw"];

/// Lists the places of a grid, row by row.
fn grid() -> impl Iterator<Item = [f32; 2]> {
    (0..POINTS).map(|point| [(point % SIDE) as f32, (point / SIDE) as f32])
}

/// Writes bits in words.
fn mask(bits: &[bool]) -> Vec<u32> {
    let word = |bits: &[bool]| bits.iter().rev().fold(0, |word, bit| word << 1 | u32::from(*bit));
    bits.chunks(32).map(word).collect()
}
