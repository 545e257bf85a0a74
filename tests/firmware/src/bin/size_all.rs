//! All that firmware calls, for models of every predictor: its weight beyond that of `bare` is the runtime's.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{EvalError, LocalTransform, Matrix3x4, Model, model_space_pose};

firmware::image!(run);

fn run() -> bool {
    frame(black_box(&[])).is_some_and(|done| black_box(done).is_ok())
}

/// Loads, poses, skins positions, normals and tangents, and bounds; `None` where nothing is loaded.
fn frame(bytes: &[u8]) -> Option<Result<(), EvalError>> {
    let envelope = Model::from_bytes(bytes).ok()?.envelope()?;
    let local = black_box::<&[LocalTransform]>(&[]);
    let (pose, maps) = black_box::<(&mut [Matrix3x4], &mut [Matrix3x4])>((&mut [], &mut []));
    let (scratch, out) = black_box::<(&mut [f32], &mut [f32])>((&mut [], &mut []));
    let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride: 10 });
    let mut frame = || {
        model_space_pose(&envelope, local, pose)?;
        black_box(envelope.palette(pose, scratch, maps)?);
        black_box(envelope.bounds(maps)?);
        SkinJob {
            envelope,
            palette: maps,
            vertices: 0..envelope.vertex_len(),
            positions: black_box(attribute(0)),
            normals: black_box(attribute(3)),
            tangents: black_box(attribute(6)),
            out_a: out,
            out_b: &mut [],
        }
        .run()
    };
    Some(frame())
}
