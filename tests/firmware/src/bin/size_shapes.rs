//! Calls the functions of `size_all` on a skin with shapes, and applies the shapes.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::frame::{shaped, whole};

firmware::image!(run);

fn run() -> bool {
    let bytes = black_box(&[]);
    let done = [whole(bytes), shaped(bytes)];
    done.into_iter().all(|done| done.is_some_and(|done| black_box(done).is_ok()))
}
