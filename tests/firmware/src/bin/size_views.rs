//! Calls the functions of views: loading, frames, and pictures.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::views::RenderScratch;
use sinew_runtime::{Frame, FrameJob, Model, RenderJob};

firmware::image!(run);

fn run() -> bool {
    let Ok(model) = Model::from_bytes(black_box::<&[u8]>(&[])) else { return false };
    picture(&model).is_some()
}

fn picture(model: &Model<&[u8]>) -> Option<()> {
    let views = model.views()?;
    let map = model.map_of(&views, black_box(0))?;
    let (parameters, scratch) = black_box::<(&[f32], &mut [f32])>((&[], &mut []));
    let (points, visibility) = black_box::<(&mut [[f32; 3]], &mut [f32])>((&mut [], &mut []));
    let (scores, layers) = black_box::<(&mut [f32], &mut [[f32; 2]])>((&mut [], &mut []));
    let frame = Frame {
        points: &mut *points,
        visibility: &mut *visibility,
        scores: &mut *scores,
        layers: &mut *layers,
    };
    black_box(FrameJob { views, map, parameters }.run(scratch, frame).ok()?);
    let job = RenderJob { views, points, visibility, scores, layers, width: black_box(0) };
    let scratch = RenderScratch {
        vertices: black_box(&mut []),
        order: black_box(&mut []),
        depths: black_box(&mut []),
        group: black_box(&mut []),
        clips: black_box(&mut []),
    };
    black_box(job.run(scratch, black_box::<&mut [[u8; 4]]>(&mut [])).ok()?);
    Some(())
}
