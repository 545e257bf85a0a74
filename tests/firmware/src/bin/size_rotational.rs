//! What firmware with rotational models calls: loading, their palette, the skin. Kernel maps, which
//! `Envelope::palette` would bring along, are left out.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use firmware::frame::skinned_by;

firmware::image!(run);

fn run() -> bool {
    skinned_by(|envelope, pose, scratch, out| envelope.rotational_palette(pose, scratch, out))
}
