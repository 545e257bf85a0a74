//! Shapes of a skin, as plain lists and in a file's blocks.

use crate::bytes::{floats, words};
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use crate::shape::{SMALL, Shape};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Element, SectionKind};

/// Vertices per block.
const BLOCK: usize = 64;

/// Shapes as plain lists.
#[derive(Clone)]
pub struct ShapeContent {
    /// Element type of deltas and slopes.
    pub element: Element,
    /// By shape: the scales of its deltas and of its slopes.
    pub steps: Vec<[f32; 2]>,
    /// By shape and vertex: three numbers of the delta and two of the slopes, whole for i8; `None`
    /// if the shape does not move the vertex.
    pub moved: Vec<Vec<Option<[f32; 5]>>>,
}

impl ShapeContent {
    /// Makes shapes with different masks: all vertices, none, every third, runs of eleven, one
    /// vertex, random halves; then the masks repeat.
    pub fn sample(element: Element, shape_len: usize, vertex_len: usize) -> Self {
        let mut rng = Rng(34);
        let moves = |shape: usize, vertex: usize, rng: &mut Rng| match shape % 6 {
            0 => true,
            1 => false,
            2 => vertex % 3 == 1,
            3 => (vertex / 11).is_multiple_of(2),
            4 => vertex + 1 == vertex_len,
            _ => rng.unit() < 0.0,
        };
        let number = |scale: f32, rng: &mut Rng| match element {
            Element::I8 => (rng.unit() * 127.0).round(),
            // A multiple of 1/64 of at most 1: exact in f16.
            _ => (rng.unit() * 64.0).round() / 64.0 * scale,
        };
        let steps = (0..shape_len).map(|shape| match element {
            Element::F32 => [1.0, 1.0],
            Element::F16 => [0.25, 0.5],
            _ => [0.001 * (shape + 1) as f32, 0.003],
        });
        let moved = (0..shape_len).map(|shape| {
            let own = (0..vertex_len).map(|vertex| {
                let [x, y, z] = [(); 3].map(|()| number(0.25, &mut rng));
                let [a, c] = [(); 2].map(|()| number(1.0, &mut rng));
                moves(shape, vertex, &mut rng).then_some([x, y, z, a, c])
            });
            own.collect()
        });
        Self { element, steps: steps.collect(), moved: moved.collect() }
    }

    /// Returns the number of shapes.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Returns whether there are no shapes.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Returns the delta of a vertex at weight 1.
    pub fn delta(&self, shape: usize, vertex: usize) -> [f32; 3] {
        let [x, y, z, ..] = self.moved[shape][vertex].unwrap_or_default();
        [x, y, z].map(|x| self.steps[shape][0] * x)
    }

    /// Returns the slopes of a vertex at weight 1.
    pub fn slopes(&self, shape: usize, vertex: usize) -> [f32; 2] {
        let [.., a, c] = self.moved[shape][vertex].unwrap_or_default();
        [a, c].map(|x| self.steps[shape][1] * x)
    }

    /// Returns the minimum and the maximum of a shape's deltas, including 0.
    fn corners(&self, shape: usize) -> [f32; 6] {
        let mut out = [0.0_f32; 6];
        for vertex in 0..self.moved[shape].len() {
            for (c, x) in self.delta(shape, vertex).into_iter().enumerate() {
                (out[c], out[3 + c]) = (out[c].min(x), out[3 + c].max(x));
            }
        }
        out
    }

    /// Encodes a number in the file's element type.
    fn number(&self, x: f32) -> Vec<u8> {
        match self.element {
            Element::I8 => vec![x as i8 as u8],
            Element::F16 => half(x).to_le_bytes().to_vec(),
            _ => x.to_le_bytes().to_vec(),
        }
    }
}

/// Encodes a multiple of 1/256 of less than 2 as f16.
fn half(x: f32) -> u16 {
    let sign = u16::from(x.is_sign_negative()) << 15;
    let bits = x.abs().to_bits();
    if x == 0.0 { sign } else { sign | ((bits >> 13) - (112 << 10)) as u16 }
}

impl Pieces {
    /// Adds shapes named "shape 0" and so on to the first skin.
    ///
    /// # Panics
    /// If there is no skin, or the skin already has shapes.
    pub fn set_shapes(&mut self, content: &ShapeContent) {
        let count = |pieces: &mut Self, at| {
            u32::from_le_bytes(*pieces.word(SectionKind::SkinCounts, at).expect("a skin"))
        };
        let (vertex_len, range_len) = (count(self, 0) as usize, count(self, 3) as usize);
        assert_eq!(count(self, 4), 0, "no shapes yet");
        let part = self.sections.iter().find(|s| s.kind == SectionKind::SkinCounts.number());
        let part = part.expect("a skin").part;
        let (mut starts, mut entries, mut start) = (vec![0], Vec::new(), 0);
        let (mut deltas, mut slopes) = (Vec::new(), Vec::new());
        for first in (0..vertex_len).step_by(BLOCK) {
            for (shape, moved) in content.moved.iter().enumerate() {
                let own = &moved[first..vertex_len.min(first + BLOCK)];
                let bits = own.iter().enumerate().map(|(at, m)| u64::from(m.is_some()) << at);
                let mask = bits.sum::<u64>();
                if mask == 0 {
                    continue;
                }
                entries.extend([mask as u32, (mask >> 32) as u32, shape as u32, start]);
                for [x, y, z, a, c] in own.iter().flatten() {
                    [x, y, z].iter().for_each(|x| deltas.extend(content.number(**x)));
                    [a, c].iter().for_each(|x| slopes.extend(content.number(**x)));
                    start += 1;
                }
            }
            starts.push(entries.len() as u32 / 4);
        }
        let rows = (0..content.len()).flat_map(|shape| {
            let ([a, b], corners) = (content.steps[shape], content.corners(shape));
            [a, b].into_iter().chain(corners)
        });
        let mut add = |kind, element: Element, bytes| {
            let content =
                Content { element: element.number(), flags: 0, ..Content::new(kind, part, bytes) };
            self.sections.push(content);
        };
        add(SectionKind::Shapes, Element::F32, floats(&rows.collect::<Vec<_>>()));
        add(SectionKind::ShapeBlocks, Element::U32, words(&starts));
        add(SectionKind::ShapeEntries, Element::U32, words(&entries));
        add(SectionKind::ShapeDeltas, content.element, deltas);
        add(SectionKind::ShapeSlopes, content.element, slopes);
        // Largest error and RMS error.
        add(SectionKind::ShapeErrors, Element::F32, floats(&[0.0625, 0.015625]));
        self.set_word(SectionKind::SkinCounts, 4, content.len() as u32);
        self.set_word(SectionKind::SkinCounts, 5, entries.len() as u32 / 4);
        self.set_word(SectionKind::SkinCounts, 6, start);
        self.name_shapes(part, 1 + range_len, content.len());
    }

    /// Appends the names of shapes to the existing names.
    fn name_shapes(&mut self, part: u16, name_len: usize, shape_len: usize) {
        let section = self.section_of(part, SectionKind::Names);
        let (ends, text) = section.split_at(4 * name_len);
        let (mut ends, mut text) = (ends.to_vec(), text.to_vec());
        for shape in 0..shape_len {
            text.extend(format!("shape {shape}").bytes());
            ends.extend((text.len() as u32).to_le_bytes());
        }
        *section = [ends, text].concat();
    }

    /// Makes the golden files of skins with shapes: f32 on an envelope with tangents and their
    /// coefficients, f16 on an envelope with neither, i8 on an envelope with tangents only, and f32
    /// without an envelope, of less than one block.
    ///
    /// # Panics
    /// As [`Pieces::sample`] does.
    pub fn shaped() -> [Self; 4] {
        let shape = Shape { vertices: 150, joints: 6, proxies: 5, influences: 4, ..SMALL };
        let plain = Shape { tangents: false, coefficients: false, ..shape };
        let bare = Shape { tangents: true, ..plain };
        let few = Shape { vertices: 9, tangents: false, ..shape };
        let all = [
            (Self::sample(Predictor::Kernel, shape), Element::F32, 150),
            (Self::sample(Predictor::Kernel, plain), Element::F16, 150),
            (Self::sample(Predictor::Kernel, bare), Element::I8, 150),
            (Self::loose(few), Element::F32, 9),
        ];
        all.map(|(mut pieces, element, vertex_len)| {
            pieces.set_shapes(&ShapeContent::sample(element, 8, vertex_len));
            pieces
        })
    }
}

/// Names of the golden skins with shapes, which [`Pieces::shaped`] makes.
pub const SHAPED_NAMES: [&str; 4] =
    ["shapes-11-f32.snw", "shapes-11-f16.snw", "shapes-11-i8.snw", "shapes-11-few.snw"];
