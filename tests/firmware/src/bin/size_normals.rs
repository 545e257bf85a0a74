//! Calls the functions of `size_all`, with normals and tangents.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::frame::whole;

firmware::image!(run);

fn run() -> bool {
    whole(black_box(&[])).is_some_and(|done| black_box(done).is_ok())
}
