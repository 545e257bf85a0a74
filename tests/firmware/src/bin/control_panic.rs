//! Must not link: an index of this image may be out of range.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::say;

firmware::image!(run);

fn run() -> bool {
    let list = black_box([1, 2, 3]);
    say!("{}", list[black_box(2)]);
    true
}
