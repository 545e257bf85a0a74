//! Calls the functions of views: loading, frames, and pictures.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use core::hint::black_box;
use sinew_runtime::views::RenderScratch;
use sinew_runtime::{Frame, FrameJob, Model, RenderJob, Views};

firmware::image!(run);

fn run() -> bool {
    let Ok(model) = Model::from_bytes(black_box::<&[u8]>(&[])) else { return false };
    picture(&model).is_some()
}

fn picture(model: &Model<&[u8]>) -> Option<()> {
    let views = model.first::<Views>()?;
    let map = model.map_of(&views, black_box(0))?;
    let (parameters, scratch) = black_box::<(&[f32], &mut [f32])>((&[], &mut []));
    let (points, visibility) = black_box::<(&mut [[f32; 3]], &mut [f32])>((&mut [], &mut []));
    let (scores, layers) = black_box::<(&mut [f32], &mut [[f32; 2]])>((&mut [], &mut []));
    let mut frame = Frame::new(points, visibility, scores, layers);
    black_box(FrameJob::new(views, map, parameters).run(scratch, &mut frame).ok()?);
    let job = RenderJob::new(views, &frame, black_box(0));
    let mut scratch = RenderScratch::new(black_box(&mut []), black_box(&mut []));
    scratch.depths = black_box(&mut []);
    scratch.group = black_box(&mut []);
    scratch.clips = black_box(&mut []);
    black_box(job.run(scratch, black_box::<&mut [[u8; 4]]>(&mut [])).ok()?);
    Some(())
}
