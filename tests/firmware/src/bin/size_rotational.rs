//! What firmware with a rotational model calls: loading, its stages one by one, and the skin. Kernel
//! maps, which [`Envelope::palette`] would bring along, are left out.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::envelope::{confidence, gradients, palette};
use sinew_runtime::{Envelope, EvalError, Matrix3x4, Model};

firmware::image!(run);

fn run() -> bool {
    let envelope = Model::from_bytes(black_box(&[])).ok().and_then(|model| model.envelope());
    envelope.is_some_and(|envelope| black_box(frame(envelope)).is_ok())
}

fn frame(envelope: Envelope<'_>) -> Result<f32, EvalError> {
    let (pose, maps) = black_box::<(&[Matrix3x4], &mut [Matrix3x4])>((&[], &mut []));
    let columns = black_box::<[&mut [[f32; 3]]; 4]>([&mut [], &mut [], &mut [], &mut []]);
    let [relative, rotations, d, positions] = columns;
    gradients::evaluate(&envelope, pose, relative, rotations, d)?;
    let root = pose.get(envelope.root()).unwrap_or(&[[0.0; 4]; 3]);
    palette::evaluate(&envelope, root, relative, d, maps)?;
    envelope.skin_positions(maps, positions)?;
    confidence::evaluate(&envelope, rotations)
}
