//! Drives a servo from two levers and the twist of a joint: a kernel in flash, three inputs, one
//! output.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use sinew_runtime::{KernelMap, Model};

firmware::image!(run);
firmware::may_panic!();

/// In flash: read in place, never copied.
static MODEL: &[u8] = include_bytes!("../../../golden/kernel-11-servo.snw");

/// Floats of scratch; `sinew inspect` prints the kernel's.
const SCRATCH: usize = 64;

fn run() -> bool {
    step().is_some()
}

fn step() -> Option<()> {
    // Once: loading checks the whole file.
    let model = Model::from_bytes(MODEL).ok()?;
    let servo = model.named::<KernelMap>("servo")?;
    let mut scratch = [0.0; SCRATCH];

    // Each step: two levers, and the wrist's rotation as a quaternion of any length. The output
    // stays within the servo's range, which the file states.
    let query = [0.25, -0.5, 0.3, 0.0, 0.1, 1.0];
    let mut angle = [0.0];
    let confidence = servo.evaluate(&query, &mut scratch, &mut angle).ok()?;

    firmware::say!("angle {angle:?}, confidence {confidence}");
    Some(())
}
