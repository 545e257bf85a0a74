//! Prints the time of a solve with pins: `cargo bench -p sinew-runtime --bench pins`. One core;
//! medians.
//!
//! 8 pins of full positions, which are 24 scalars, on a face of 53 correlated shapes.
#![allow(missing_docs, reason = "a program")]

use models::{Pieces, PriorContent, SMALL, Shape, ShapeContent};
use sinew_runtime::format::Element;
use sinew_runtime::prior::Edit;
use sinew_runtime::{CallError, FileError, Model, Pin, PinJob, Pins, Prior, Skin};
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 401;
const SHAPES: usize = 53;
const PINS: usize = 8;

#[derive(Debug)]
#[expect(dead_code, reason = "shown where main fails")]
enum Refused {
    File(FileError),
    Call(CallError),
}

fn main() -> Result<(), Refused> {
    let mut pieces = Pieces::loose(Shape { vertices: 1024, ..SMALL });
    pieces.set_shapes(&ShapeContent::sample(Element::F32, SHAPES, 1024));
    pieces.add_prior(&PriorContent::sample(0, SHAPES));
    let bytes = pieces.bytes();
    let model = Model::from_bytes(bytes.as_slice()).map_err(Refused::File)?;
    let (Some(prior), Some(skin)) = (model.first::<Prior>(), model.first::<Skin>()) else {
        return Ok(());
    };
    let scalars = 3 * PINS;
    let mut scratch = vec![0.0; prior.counts().pin_scratch_len(scalars)];
    println!("scratch: {} bytes", 8 * scratch.len());
    let start: Vec<f32> = (0..SHAPES).map(|shape| prior.mean(shape).unwrap_or_default()).collect();
    // Distance of the pull, in steps of a drag.
    let pins = |step: usize| -> Result<Pins<PINS>, CallError> {
        let mut pins = Pins::new();
        for pin in 0..PINS {
            let vertex = (pin * 127 + 3) as u32;
            let [x, y, z] = skin.place(vertex, &[], &start).unwrap_or_default();
            let by = 0.2 + 0.01 * step as f32;
            pins.add(Pin::new(vertex, [x + by, y - 0.5 * by, z + 0.3 * by]))?;
        }
        Ok(pins)
    };
    for is_bounded in [false, true] {
        for is_drag in [false, true] {
            let (mut times, mut rounds) = (Vec::new(), 0);
            for run in 0..RUNS {
                let pins = pins(run % 16).map_err(Refused::Call)?;
                let mut weights = start.clone();
                if !is_drag {
                    scratch.fill(0.0);
                }
                let job = PinJob { is_bounded, ..PinJob::new(prior, skin, pins.list()) };
                let before = Instant::now();
                let done: Edit = job.run(&mut scratch, &mut weights).map_err(Refused::Call)?;
                times.push(before.elapsed().as_secs_f64());
                rounds = rounds.max(done.round_len);
                black_box(weights);
            }
            times.sort_by(f64::total_cmp);
            let name = if is_bounded { "bounded" } else { "unbounded" };
            let how = if is_drag { "drag" } else { "anew" };
            println!("{name}, {how}: {:.1} us, at most {rounds} rounds", 1e6 * times[RUNS / 2]);
        }
    }
    Ok(())
}
