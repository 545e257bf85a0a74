//! What firmware with views calls: loading, frames, and pictures in either order.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::views::Order;
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
    let (scores, last) = black_box::<(&mut [f32], _)>((&mut [], None));
    let job = FrameJob { views, map, parameters, last, margin: views.fit().margin };
    let frame = Frame { points: &mut *points, visibility: &mut *visibility, scores: &mut *scores };
    let view = job.run(scratch, frame).ok()?.view;
    let job = RenderJob { views, points, visibility, scores, view, width: black_box(0) };
    let pixels = black_box::<&mut [[u8; 4]]>(&mut []);
    black_box(job.run(Order::Depth(black_box(&mut [])), pixels).ok()?);
    black_box(job.run(Order::Painter(black_box(&mut [])), pixels).ok()?);
    Some(())
}
