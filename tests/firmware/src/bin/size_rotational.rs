//! Calls the functions for rotational models: loading, palette, skin. Kernel maps are not linked;
//! `Envelope::palette` would link them.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use firmware::frame::skinned_by;

firmware::image!(run);

fn run() -> bool {
    skinned_by(|envelope, pose, scratch, out| envelope.rotational_palette(pose, scratch, out))
}
