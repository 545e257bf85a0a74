//! Does nothing: the baseline for the sizes of other images.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

firmware::image!(run);

fn run() -> bool {
    core::hint::black_box(true)
}
