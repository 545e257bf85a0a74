//! Makes a sensor's signal four times as fine: a filter in flash, a block of samples at a time.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use sinew_runtime::Model;
use sinew_runtime::filter::Samples;

firmware::image!(run);
firmware::may_panic!();

/// In flash: read where it lies, never copied.
static MODEL: &[u8] = include_bytes!("../../../golden/filter-8.snw");

/// Samples of a block, and how many times as fine they become.
const BLOCK: usize = 16;
const FACTOR: usize = 4;

fn run() -> bool {
    block().is_some()
}

fn block() -> Option<()> {
    // Once: all of the file is checked here.
    let model = Model::from_bytes(MODEL).ok()?;
    let filter = model.filter_named("sensor")?;
    let mut fine = [0.0; FACTOR * BLOCK];

    // Each block: here the squares of its samples' numbers. Two samples at either end see fewer beyond them, so
    // blocks of a long signal overlap by four.
    let mut samples = [0.0; BLOCK];
    for (number, sample) in samples.iter_mut().enumerate() {
        *sample = (number * number) as f32;
    }
    filter.apply(Samples::of_signal(BLOCK), &samples, &mut fine).ok()?;

    firmware::say!("fine samples {:?}", fine.get(8 * FACTOR..10 * FACTOR)?);
    Some(())
}
