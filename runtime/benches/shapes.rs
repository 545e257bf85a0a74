//! Prints the time of shapes beside a plain sum over their bytes: `cargo bench -p sinew-runtime
//! --bench shapes`. With `RUSTFLAGS="-C target-cpu=x86-64-v3"` registers are wider. `-- FILE`
//! measures a model's skin instead.
//!
//! One core; medians of runs taken in turn, so that ratios hold on a busy machine.

use models::{Pieces, SMALL, Shape, ShapeContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Element, SectionKind};
use sinew_runtime::skin::Output;
use sinew_runtime::{CallError, Model, ShapesJob, Skin};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 31;
/// 36 MB of deltas in f32, larger than any L2 cache.
const VERTICES: usize = 60_000;
const SHAPES: usize = 50;

/// Whether a shape moves a vertex.
type Mask = fn(usize, usize) -> bool;

/// Which vertices a shape moves: all; runs of some dozens, as in a face; scattered vertices.
const MASKS: [(&str, Mask); 3] = [
    ("every vertex", |_, _| true),
    ("runs of 40", |shape, vertex| (vertex / 40 + shape) % 3 == 0),
    ("every third", |shape, vertex| (vertex + shape) % 3 == 0),
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("mask           element  positions  a sum   ratio  with normals  a sum   ratio, ms");
    // Cargo adds `--bench` itself.
    if let Some(file) = std::env::args().skip(1).find(|argument| argument != "--bench") {
        return print("the file's", &Model::from_bytes(std::fs::read(file)?)?);
    }
    for (name, mask) in MASKS {
        for element in [Element::F32, Element::F16, Element::I8] {
            print(name, &model(element, mask)?)?;
        }
    }
    Ok(())
}

fn print(mask: &str, model: &Model<Vec<u8>>) -> Result<(), Box<dyn Error>> {
    let skin = model.first::<Skin>().ok_or("no skin")?;
    let [alone, sum, both, sum_of_both] = seconds(model, skin)?;
    println!(
        "{mask:<15}{:<7}{:>10.2}{:>8.2}{:>7.2}{:>13.2}{:>8.2}{:>7.2}",
        skin.shape_element().name(),
        1e3 * alone,
        1e3 * sum,
        alone / sum,
        1e3 * both,
        1e3 * sum_of_both,
        both / sum_of_both,
    );
    Ok(())
}

fn model(element: Element, mask: Mask) -> Result<Model<Vec<u8>>, Box<dyn Error>> {
    let shape = Shape { vertices: VERTICES, tangents: false, coefficients: false, ..SMALL };
    let mut content = ShapeContent::sample(element, 1, VERTICES);
    let whole = content.moved.pop().ok_or("a shape")?;
    let step = content.steps.pop().ok_or("a shape")?;
    let moved = |shape: usize| {
        let own =
            |(vertex, numbers): (usize, &Option<[f32; 5]>)| numbers.filter(|_| mask(shape, vertex));
        whole.iter().enumerate().map(own).collect()
    };
    content.moved = (0..SHAPES).map(moved).collect();
    content.steps = vec![step; SHAPES];
    let mut pieces = Pieces::sample(Predictor::Rotational, shape);
    pieces.set_shapes(&content);
    Ok(Model::from_bytes(pieces.bytes())?)
}

/// Measures four times: positions, a sum over the bytes of their deltas, positions with normals,
/// and a sum that also covers the slopes.
fn seconds(model: &Model<Vec<u8>>, skin: Skin<'_>) -> Result<[f64; 4], Box<dyn Error>> {
    let weights: Vec<f32> =
        (0..skin.shape_len()).map(|shape| 0.25 + shape as f32 / 100.0).collect();
    let section = |kind: SectionKind| {
        let mut all = model.sections();
        all.find(|section| section.row.kind == kind.number()).map(|section| section.bytes)
    };
    let deltas = section(SectionKind::ShapeDeltas).ok_or("no deltas")?;
    let slopes = section(SectionKind::ShapeSlopes).ok_or("no slopes")?;
    let floats = 3 * skin.vertex_len();
    let (mut positions, mut normals) = (vec![0.0; floats], vec![0.0; floats]);
    let mut shape = |with_normals: bool| -> Result<(), CallError> {
        let to = |floats| Some(Output::new(floats, 3));
        ShapesJob::new(skin, black_box(&weights))
            .positions(to(&mut positions))
            .normals(to(&mut normals).filter(|_| with_normals))
            .run()
    };
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..RUNS {
        times[0].push(timed(|| shape(false))?);
        times[1].push(timed(|| {
            sum(skin.shape_element(), black_box(deltas));
            Ok(())
        })?);
        times[2].push(timed(|| shape(true))?);
        times[3].push(timed(|| {
            sum(skin.shape_element(), black_box(deltas));
            sum(skin.shape_element(), black_box(slopes));
            Ok(())
        })?);
    }
    Ok(times.map(|mut seconds| {
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    }))
}

/// Adds all numbers of some bytes, with 16 sums side by side.
fn sum(element: Element, bytes: &[u8]) {
    fn lanes<const B: usize>(bytes: &[u8], read: impl Fn([u8; B]) -> f32) {
        let mut sums = [0.0; 16];
        for numbers in bytes.as_chunks::<B>().0.as_chunks::<16>().0 {
            sums.iter_mut().zip(numbers).for_each(|(sum, le)| *sum += 0.5 * read(*le));
        }
        black_box(sums);
    }
    match element {
        // The sum measures reading bytes, so it does not decode half precision.
        Element::F16 => lanes(bytes, |le| f32::from(i16::from_le_bytes(le))),
        Element::I8 => lanes(bytes, |le| f32::from(i8::from_le_bytes(le))),
        _ => lanes(bytes, f32::from_le_bytes),
    }
}

fn timed(run: impl FnOnce() -> Result<(), CallError>) -> Result<f64, CallError> {
    let start = Instant::now();
    run()?;
    Ok(start.elapsed().as_secs_f64())
}
