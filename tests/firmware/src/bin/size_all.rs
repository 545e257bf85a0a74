//! All that firmware calls, for models of every predictor: its weight beyond that of `bare` is the runtime's.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::skin::{Output, Rest, cells};
use sinew_runtime::{CallError, LocalTransform, Matrix3x4, Model, SkinJob, model_space_pose};

firmware::image!(run);

fn run() -> bool {
    frame(black_box(&[])).is_some_and(|done| black_box(done).is_ok())
}

/// Loads, poses, skins positions, normals and tangents, and bounds; `None` where nothing is loaded.
fn frame(bytes: &[u8]) -> Option<Result<(), CallError>> {
    let model = Model::from_bytes(bytes).ok()?;
    let (envelope, skin) = (model.envelope()?, model.skin()?);
    let local = black_box::<&[LocalTransform]>(&[]);
    let (pose, palette) = black_box::<(&mut [Matrix3x4], &mut [Matrix3x4])>((&mut [], &mut []));
    let (scratch, out) = black_box::<(&mut [f32], &mut [f32])>((&mut [], &mut []));
    let lent = cells(out);
    let attribute = |start: usize| Some(Output { floats: lent.get(start..)?, stride: 10 });
    let mut frame = || {
        model_space_pose(&envelope, local, pose)?;
        black_box(envelope.palette(pose, scratch, palette)?);
        black_box(skin.bounds(palette, 0.0)?);
        SkinJob {
            skin,
            palette,
            vertices: 0..skin.vertex_len(),
            remap: None,
            rest: Rest::default(),
            positions: black_box(attribute(0)),
            normals: black_box(attribute(3)),
            tangents: black_box(attribute(6)),
        }
        .run()
    };
    Some(frame())
}
