//! Writes a skin and its shapes as a part of a file. Shapes are stored by blocks of vertices. A block holds the deltas
//! of every shape that moves at least one of its vertices.

use crate::Error;
use crate::bake::Part;
use crate::bake::sections::{check_len, floats, half, halves, names, narrow, words};
use crate::envelope::model::{EnvelopeModel, ShapeNumbers, Shapes, SkinModel};
use half::f16;
use nalgebra::Vector3;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::skin::{BLOCK, NO_ENVELOPE, SKIN_SECTIONS, ShapeErrors, SkinCounts};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Sections of shapes.
const SHAPE_SECTIONS: [SectionKind; 6] = [
    SectionKind::Shapes,
    SectionKind::ShapeBlocks,
    SectionKind::ShapeEntries,
    SectionKind::ShapeDeltas,
    SectionKind::ShapeSlopes,
    SectionKind::ShapeErrors,
];
/// Size of an entry in bytes.
const ENTRY_BYTES: usize = 16;
/// Vertices of a block of attributes.
const EIGHT: usize = 8;

impl SkinModel {
    /// Writes the skin as a part.
    ///
    /// - `envelope`: the envelope with the index `self.envelope`.
    ///
    /// # Errors
    /// Those of [`FileModel::bake`](crate::envelope::model::FileModel::bake) that concern a skin.
    pub(super) fn part(&self, envelope: Option<&EnvelopeModel>) -> Result<Part, Error> {
        let v = self.rest_positions.len();
        check_len("rest normals", v, self.rest_normals.len())?;
        check_len("rest tangents", v, self.rest_tangents.as_ref().map_or(v, Vec::len))?;
        check_len("influences", envelope.map_or(0, |_| v), self.influences.len())?;
        let shapes = shape_sections(&self.shapes, v)?;
        let k = self.influence_len().max(usize::from(envelope.is_some()));
        let counts = SkinCounts {
            vertex_len: narrow("vertices", v)?,
            influence_len: narrow("influences", k)?,
            envelope: self.envelope.map_or(Ok(NO_ENVELOPE), |number| narrow("envelope", number))?,
            range_len: narrow("ranges", self.ranges.len())?,
            shape_len: narrow("shapes", self.shapes.len())?,
            entry_len: narrow("entries of shapes", shapes.entry_len())?,
            delta_len: narrow("deltas of shapes", shapes.delta_len)?,
        };
        let rounded: Vec<_> = self.rest_positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let mut ranges = Vec::new();
        for (_, range) in &self.ranges {
            ranges.extend([narrow::<u32>("vertex", range.start)?, narrow("vertex", range.end)?]);
        }
        let range_names = self.ranges.iter().map(|(name, _)| name);
        let all_names = [&self.name].into_iter().chain(range_names).chain(&self.shapes.names);
        let palette_len = envelope.map_or(0, EnvelopeModel::palette_len);
        if let Some(all) = &self.tangent_coefficients {
            check_len("vertices with tangent coefficients", v, all.len())?;
            for own in all {
                check_len("tangent coefficients of a vertex", k, own.len())?;
            }
        }
        let slots = self.slots(k)?;
        let mut indices = Vec::new();
        for slots in &slots {
            let of = |slot: &Slot| narrow::<u16>("palette index", slot.index);
            indices.push(slots.iter().map(of).collect::<Result<Vec<_>, _>>()?);
        }
        let of_slots = |slots: &Vec<Slot>| slots.iter().map(|slot| slot.weight).collect::<Vec<_>>();
        let weights: Vec<_> = slots.iter().map(of_slots).collect();
        let of_slots = |slots: &Vec<Slot>| {
            slots.iter().skip(1).map(|slot| slot.coefficients).collect::<Vec<_>>()
        };
        let coefficients: Vec<_> = slots.iter().map(of_slots).collect();
        let halfwords = |row: &[u16]| row.iter().flat_map(|index| index.to_le_bytes()).collect();
        let pairs = |row: &[[f64; 2]]| halves(row.iter().flatten().copied());
        let contents = [
            (SectionKind::SkinCounts, Some(words(&counts.words()))),
            (SectionKind::Names, Some(names(all_names)?)),
            (SectionKind::RestPositions, Some(eights(&self.rest_positions, floats))),
            (SectionKind::RestNormals, Some(eights(&self.rest_normals, floats))),
            (
                SectionKind::RestTangents,
                self.rest_tangents.as_ref().map(|tangents| eights(tangents, floats)),
            ),
            (SectionKind::InfluenceIndices, Some(eights(&indices, halfwords))),
            (SectionKind::InfluenceWeights, Some(eights(&weights, floats))),
            (SectionKind::RestBoxes, Some(rest_boxes(self, &rounded, palette_len))),
            (SectionKind::Ranges, Some(words(&ranges))),
            (
                SectionKind::TangentCoefficients,
                self.tangent_coefficients.as_ref().map(|_| eights(&coefficients, pairs)),
            ),
            (
                SectionKind::NormalErrors,
                self.normal_errors.map(|errors| floats(&errors.figures().map(f64::from))),
            ),
            (SectionKind::Shapes, Some(shapes.rows)),
            (SectionKind::ShapeBlocks, Some(shapes.blocks)),
            (SectionKind::ShapeEntries, Some(shapes.entries)),
            (SectionKind::ShapeDeltas, Some(shapes.deltas)),
            (SectionKind::ShapeSlopes, Some(shapes.slopes)),
            (SectionKind::ShapeErrors, Some(shapes.errors)),
        ];
        debug_assert!(contents.iter().map(|(kind, _)| *kind).eq(SKIN_SECTIONS));
        let own = contents.into_iter().filter(|(kind, _)| counts.has(*kind) != Some(false));
        // A reader may ignore shapes and optional sections.
        let required = |kind| counts.has(kind) == Some(true) && !SHAPE_SECTIONS.contains(&kind);
        let own = own.filter_map(|(kind, content)| Some((kind, required(kind), content?)));
        Ok(Part {
            kind: PartKind::Skin,
            sections: own.collect(),
            element: self.shapes.numbers.element(),
        })
    }
}

/// Writes numbers of vertices by blocks of eight vertices: for each number a row of eight. The last vertex fills the
/// last block.
///
/// - `vertices`: numbers of each vertex; the lists have one length.
/// - `row`: writes a row.
fn eights<T: Copy>(vertices: &[impl AsRef<[T]>], row: impl Fn(&[T]) -> Vec<u8>) -> Vec<u8> {
    let mut out = Vec::new();
    for block in vertices.chunks(EIGHT) {
        for number in 0..block[0].as_ref().len() {
            let own = |lane: usize| block[lane.min(block.len() - 1)].as_ref()[number];
            out.extend(row(&std::array::from_fn::<_, EIGHT, _>(own)));
        }
    }
    out
}

/// An influence of a vertex in the order of the file.
#[derive(Clone, Copy, Default)]
struct Slot {
    index: usize,
    weight: f64,
    coefficients: [f64; 2],
}

impl SkinModel {
    /// Returns the K influences of each vertex in the order of the file, with normalised weights.
    fn slots(&self, k: usize) -> Result<Vec<Vec<Slot>>, Error> {
        let mut out = Vec::new();
        for (vertex, influences) in self.influences.iter().enumerate() {
            let sum = influences.iter().map(|&(_, weight)| weight).sum::<f64>();
            if !(sum > 0.0 && sum.is_finite()) {
                let message = format!("the weights of vertex {vertex} sum to {sum}, expected 1");
                return Err(Error::value(message));
            }
            let coefficients = self.tangent_coefficients.as_ref().map(|all| &all[vertex]);
            let mut slots: Vec<Slot> = Vec::new();
            for (at, &(index, weight)) in influences.iter().enumerate() {
                let [g, h] = coefficients.map_or([0.0; 2], |own| own[at]);
                if let Some(own) = slots.iter_mut().find(|slot| slot.index == index) {
                    let [own_g, own_h] = own.coefficients;
                    own.weight += weight / sum;
                    own.coefficients = [own_g + g, own_h + h];
                } else {
                    slots.push(Slot { index, weight: weight / sum, coefficients: [g, h] });
                }
            }
            out.push(slots);
        }
        out.chunks_mut(EIGHT).for_each(|block| arrange(block, k));
        Ok(out)
    }
}

/// Orders the influences of a block of vertices so that as many slots as possible have one transform in all vertices:
/// a reader then looks up one transform instead of eight. The coefficients of the other slots refer to the first slot,
/// an influence that each vertex has. Fills every vertex to K slots.
fn arrange(block: &mut [Vec<Slot>], k: usize) {
    let is_used = |slot: &Slot| slot.weight > 0.0 || slot.coefficients != [0.0; 2];
    block.iter_mut().for_each(|slots| slots.retain(is_used));
    let mut counts = BTreeMap::<usize, usize>::new();
    for slot in block.iter().flatten() {
        *counts.entry(slot.index).or_default() += 1;
    }
    let mut common: Vec<_> = counts.into_iter().collect();
    common.sort_by_key(|&(index, count)| (Reverse(count), index));
    let (mut ordered, len) = (vec![Vec::new(); block.len()], block.len());
    // Without a transform that all have, the strongest of each vertex is the first.
    if common.first().is_none_or(|&(_, count)| count < len) {
        for (slots, out) in block.iter_mut().zip(&mut ordered) {
            let strongest = (0..slots.len())
                .max_by(|&a, &b| slots[a].weight.total_cmp(&slots[b].weight).then(b.cmp(&a)));
            out.extend(strongest.map(|at| slots.remove(at)));
        }
    }
    for (index, _) in common {
        let others = |slots: &[Slot]| slots.iter().filter(|slot| slot.index != index).count();
        let has_room = block.iter().zip(&ordered).all(|(slots, out)| out.len() + others(slots) < k);
        // A vertex whose strongest influence this is has it in the first slot.
        if !has_room || block.iter().flatten().all(|slot| slot.index != index) {
            continue;
        }
        for (slots, out) in block.iter_mut().zip(&mut ordered) {
            let own = slots.iter().position(|slot| slot.index == index);
            out.push(own.map_or(Slot { index, ..Slot::default() }, |at| slots.remove(at)));
        }
    }
    for (slots, mut out) in block.iter_mut().zip(ordered) {
        out.append(slots);
        let last = out.last().map_or(0, |slot| slot.index);
        out.resize(k, Slot { index: last, ..Slot::default() });
        *slots = out;
    }
}

/// Computes a box per transform of the palette: bounds of the rounded rest positions that the transform moves. The box
/// has min > max if the transform moves no vertex.
fn rest_boxes(skin: &SkinModel, rest_positions: &[[f32; 3]], palette_len: usize) -> Vec<u8> {
    let mut boxes = vec![None::<([f32; 3], [f32; 3])>; palette_len];
    for (influences, &x) in skin.influences.iter().zip(rest_positions) {
        for &(index, weight) in influences {
            let Some(rest_box) = boxes.get_mut(index).filter(|_| weight > 0.0) else { continue };
            let (min, max) = rest_box.unwrap_or((x, x));
            let union = |i: usize| (min[i].min(x[i]), max[i].max(x[i]));
            let [x, y, z] = [0, 1, 2].map(union);
            *rest_box = Some(([x.0, y.0, z.0], [x.1, y.1, z.1]));
        }
    }
    let corners = boxes.into_iter().map(|rest_box| rest_box.unwrap_or(([1.0; 3], [-1.0; 3])));
    corners.flat_map(|(min, max)| min.into_iter().chain(max)).flat_map(f32::to_le_bytes).collect()
}

/// Content of the sections of shapes.
#[derive(Default)]
struct ShapeSections {
    rows: Vec<u8>,
    blocks: Vec<u8>,
    entries: Vec<u8>,
    deltas: Vec<u8>,
    slopes: Vec<u8>,
    errors: Vec<u8>,
    delta_len: usize,
}

impl ShapeSections {
    /// Returns the number of entries.
    fn entry_len(&self) -> usize {
        self.entries.len() / ENTRY_BYTES
    }
}

/// A shape, rounded as in a file.
struct Rounded {
    /// Factors of the file's numbers: of deltas, then of slopes.
    steps: [f32; 2],
    /// Numbers of each vertex: three for its delta, two for its slopes.
    numbers: Vec<[f32; 5]>,
}

/// Writes all shapes of a skin.
fn shape_sections(shapes: &Shapes, vertex_len: usize) -> Result<ShapeSections, Error> {
    check_len("deltas of all shapes", shapes.len(), shapes.deltas.len())?;
    check_len("slopes of all shapes", shapes.len(), shapes.slopes.len())?;
    let mut out = ShapeSections::default();
    let (mut all, mut errors) = (Vec::new(), Errors::default());
    for (deltas, slopes) in shapes.deltas.iter().zip(&shapes.slopes) {
        check_len("deltas of a shape", vertex_len, deltas.len())?;
        check_len("slopes of a shape", vertex_len, slopes.len())?;
        let rounded = Rounded::new(shapes.numbers, deltas, slopes);
        errors.measure(&rounded, deltas);
        out.rows.extend(rounded.row().into_iter().flat_map(f32::to_le_bytes));
        all.push(rounded);
    }
    let mut starts = vec![0];
    for first in (0..vertex_len).step_by(BLOCK) {
        let vertices = first..vertex_len.min(first + BLOCK);
        for (shape, rounded) in all.iter().enumerate() {
            let own = &rounded.numbers[vertices.clone()];
            let bit = |(at, numbers): (usize, &[f32; 5])| u64::from(is_moved(numbers)) << at;
            let mask = own.iter().enumerate().map(bit).sum::<u64>();
            if mask == 0 {
                continue;
            }
            let (low, high) = (mask as u32, (mask >> 32) as u32);
            let start = narrow("deltas of shapes", out.delta_len)?;
            out.entries.extend(words(&[low, high, narrow("shapes", shape)?, start]));
            out.delta_len += mask.count_ones() as usize;
            for numbers in own.iter().filter(|numbers| is_moved(numbers)) {
                let (delta, slopes) = numbers.split_at(3);
                out.deltas.extend(delta.iter().flat_map(|x| shapes.numbers.bytes(*x)));
                out.slopes.extend(slopes.iter().flat_map(|x| shapes.numbers.bytes(*x)));
            }
        }
        starts.push(narrow("entries of shapes", out.entry_len())?);
    }
    out.blocks = words(&starts);
    out.errors = errors.figures().figures().into_iter().flat_map(f32::to_le_bytes).collect();
    Ok(out)
}

/// Returns true if a delta or slope is not 0.
fn is_moved(numbers: &[f32; 5]) -> bool {
    numbers.iter().any(|x| *x != 0.0)
}

impl Rounded {
    fn new(numbers: ShapeNumbers, deltas: &[[f64; 3]], slopes: &[[f64; 2]]) -> Self {
        let steps = [numbers.step(deltas.as_flattened()), numbers.step(slopes.as_flattened())];
        let all = deltas.iter().zip(slopes).map(|([x, y, z], [a, c])| {
            let [of_delta, of_slope] =
                steps.map(|step| move |x: &f64| numbers.rounded(x / f64::from(step)));
            [of_delta(x), of_delta(y), of_delta(z), of_slope(a), of_slope(c)]
        });
        Self { steps, numbers: all.collect() }
    }

    /// Computes a vertex's delta as the runtime does.
    fn delta(&self, [x, y, z, ..]: &[f32; 5]) -> [f32; 3] {
        [x, y, z].map(|x| self.steps[0] * x)
    }

    /// Returns the row of the shape: steps, and the box around its deltas and 0.
    fn row(&self) -> [f32; 8] {
        let (mut min, mut max) = ([0.0_f32; 3], [0.0_f32; 3]);
        for delta in self.numbers.iter().map(|numbers| self.delta(numbers)) {
            for (x, (min, max)) in delta.into_iter().zip(min.iter_mut().zip(&mut max)) {
                (*min, *max) = (min.min(x), max.max(x));
            }
        }
        let ([a, b], [x0, y0, z0], [x1, y1, z1]) = (self.steps, min, max);
        [a, b, x0, y0, z0, x1, y1, z1]
    }
}

impl ShapeNumbers {
    /// Chooses the factor of the numbers in a file, so that the largest number has the best relative precision.
    fn step(self, values: &[f64]) -> f32 {
        if values.iter().any(|x| !x.is_finite()) {
            // Every reader refuses NaN.
            return f32::NAN;
        }
        let max = values.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        match self {
            // A factor of 1 is exact.
            _ if max == 0.0 => 1.0,
            Self::F32 => 1.0,
            // A power of two is exact. The largest number becomes less than 2, so the smallest normal number is 3e-5 of
            // it.
            Self::F16 => 2.0_f64.powf(max.log2().floor().max(-120.0)) as f32,
            Self::I8 => (max / 127.0) as f32,
        }
    }

    /// Rounds a number to the number type of the file.
    fn rounded(self, x: f64) -> f32 {
        match self {
            Self::F32 => x as f32,
            Self::F16 => half(x).to_f32(),
            Self::I8 => x.round().clamp(-127.0, 127.0) as f32,
        }
    }

    /// Writes a rounded number.
    fn bytes(self, x: f32) -> Vec<u8> {
        match self {
            Self::F32 => x.to_le_bytes().to_vec(),
            Self::F16 => f16::from_f32_const(x).to_le_bytes().to_vec(),
            Self::I8 => (x as i8).to_le_bytes().to_vec(),
        }
    }
}

/// Rounding errors of deltas.
#[derive(Default)]
struct Errors {
    largest: f64,
    squares: f64,
    len: usize,
}

impl Errors {
    fn measure(&mut self, rounded: &Rounded, deltas: &[[f64; 3]]) {
        for (numbers, delta) in rounded.numbers.iter().zip(deltas) {
            let found = Vector3::from(rounded.delta(numbers).map(f64::from));
            let error = (found - Vector3::from(*delta)).norm();
            self.largest = self.largest.max(error);
            self.squares += error * error;
            self.len += usize::from(*delta != [0.0; 3]);
        }
    }

    fn figures(&self) -> ShapeErrors {
        let rms = (self.squares / self.len.max(1) as f64).sqrt();
        ShapeErrors { largest: self.largest as f32, rms: rms as f32 }
    }
}
