//! Calls the functions for models of any predictor: loading, palette, skin.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use firmware::frame::skinned_by;

firmware::image!(run);

fn run() -> bool {
    skinned_by(|envelope, pose, scratch, out| {
        envelope.palette(pose, black_box::<&[f32]>(&[]), scratch, out)
    })
}
