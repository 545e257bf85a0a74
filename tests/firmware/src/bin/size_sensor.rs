//! Calls the functions of filters: loading, and filtering a signal.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::filter::Samples;
use sinew_runtime::{Filter, Model};

firmware::image!(run);

fn run() -> bool {
    let Ok(model) = Model::from_bytes(black_box::<&[u8]>(&[])) else { return false };
    let Some(filter) = model.first::<Filter>() else { return false };
    let shape = Samples::of_signal(black_box(0));
    filter.apply(shape, black_box(&[]), black_box(&mut [])).is_ok()
}
