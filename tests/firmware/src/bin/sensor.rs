//! Multiplies the sample rate of a sensor's signal by four, one block at a time: a filter in flash.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use sinew_runtime::filter::Samples;
use sinew_runtime::{Filter, Model};

firmware::image!(run);
firmware::may_panic!();

/// In flash: read in place, never copied.
static MODEL: &[u8] = include_bytes!("../../../golden/filter-11.snw");

/// Samples per block, and the factor of the sample rate.
const BLOCK: usize = 16;
const FACTOR: usize = 4;

fn run() -> bool {
    block().is_some()
}

fn block() -> Option<()> {
    // Once: loading checks the whole file.
    let model = Model::from_bytes(MODEL).ok()?;
    let filter = model.named::<Filter>("sensor")?;
    let mut fine = [0.0; FACTOR * BLOCK];

    // Each block: here sample k is k². The two samples at either end have fewer neighbours, so
    // blocks of a long signal overlap by four.
    let mut samples = [0.0; BLOCK];
    for (number, sample) in samples.iter_mut().enumerate() {
        *sample = (number * number) as f32;
    }
    filter.apply(Samples::of_signal(BLOCK), &samples, &mut fine).ok()?;

    firmware::say!("fine samples {:?}", fine.get(8 * FACTOR..10 * FACTOR)?);
    Some(())
}
