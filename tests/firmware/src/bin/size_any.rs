//! What firmware with models of any predictor calls: loading, their palette, the skin.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use firmware::frame::skinned_by;
use sinew_runtime::Envelope;

firmware::image!(run);

fn run() -> bool {
    skinned_by(Envelope::palette)
}
