//! How a file holds the shapes of a skin: by blocks of vertices, each shape's deltas where it moves any.

use crate::bake::BakeError;
use crate::bake::sections::{check_len, half, narrow, words};
use crate::envelope::model::{ShapeNumbers, Shapes};
use half::f16;
use nalgebra::Vector3;
use sinew_runtime::skin::{BLOCK, ShapeErrors};

/// What the sections of shapes hold.
#[derive(Default)]
pub(super) struct ShapeSections {
    pub(super) rows: Vec<u8>,
    pub(super) blocks: Vec<u8>,
    pub(super) entries: Vec<u8>,
    pub(super) deltas: Vec<u8>,
    pub(super) slopes: Vec<u8>,
    pub(super) errors: Vec<u8>,
    pub(super) delta_len: usize,
}

/// Bytes of an entry.
const ENTRY_BYTES: usize = 16;

impl ShapeSections {
    /// Counts the entries.
    pub(super) fn entry_len(&self) -> usize {
        self.entries.len() / ENTRY_BYTES
    }
}

/// A shape as a file holds it.
struct Rounded {
    /// What a file's numbers are multiplied by, of deltas and of slopes.
    steps: [f32; 2],
    /// Numbers of each vertex: of its delta, then of its slopes.
    numbers: Vec<[f32; 5]>,
}

/// Writes all shapes of a skin of so many vertices.
pub(super) fn write(shapes: &Shapes, vertex_len: usize) -> Result<ShapeSections, BakeError> {
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

    /// Gives a vertex's delta as the runtime computes it.
    fn delta(&self, [x, y, z, ..]: &[f32; 5]) -> [f32; 3] {
        [x, y, z].map(|x| self.steps[0] * x)
    }

    /// Gives the row of the shape: steps, and the box of its deltas and 0.
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
    /// Chooses what numbers are multiplied by, so that the largest has the most places.
    fn step(self, values: &[f64]) -> f32 {
        let most = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        match self {
            // A product by 1 is exact.
            _ if most == 0.0 || !most.is_finite() => 1.0,
            Self::F32 => 1.0,
            // A power of two is exact; the largest becomes less than 2, so the least that counts is 3e-5 of it.
            Self::F16 => 2.0_f64.powf(most.log2().floor().max(-120.0)) as f32,
            Self::I8 => (most / 127.0) as f32,
        }
    }

    /// Rounds a number to one of the file's.
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

/// How far rounding takes deltas.
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
