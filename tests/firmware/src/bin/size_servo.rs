//! Calls the functions of kernels: loading, and outputs.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::{KernelMap, Model};

firmware::image!(run);

fn run() -> bool {
    let Ok(model) = Model::from_bytes(black_box::<&[u8]>(&[])) else { return false };
    let Some(kernel) = model.first::<KernelMap>() else { return false };
    let (query, scratch) = black_box::<(&[f32], &mut [f32])>((&[], &mut []));
    black_box(kernel.evaluate(query, scratch, black_box(&mut []))).is_ok()
}
