//! Views: descriptions, results with the runtime's bits, and refused calls.

use crate::handles::{Loaded, NONE, done, get, name, unwritten};
use models::{KernelContent, Pieces, Rng, ViewsContent};
use sinew_capi::*;
use sinew_runtime::views::{Layer, RenderScratch};
use sinew_runtime::{Frame, FrameJob, Model, RenderJob, Views};
use std::ptr::{null, null_mut};

/// Number of pixels of a picture: 40 rows of 48.
const PIXELS: usize = 48 * 40;

fn described(views: *const sinew_views) -> sinew_views_info {
    // SAFETY: open views and a structure to be written.
    get(|out| unsafe { sinew_views_describe(views, out, NONE) })
}

#[test]
fn views_have_the_runtimes_description_and_bits() {
    let [file, _] = Pieces::viewed().map(|pieces| pieces.bytes());
    let (loaded, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    let expected = model.first::<Views>().unwrap();
    let opened = loaded.open::<sinew_views>(sinew_part_kind::Views, None, 0).unwrap();
    let views = opened.handle;
    let info = described(views);
    // SAFETY: open views and a structure to be written.
    let map = get(|out| unsafe { sinew_views_map(views, 1, out, NONE) });
    assert_eq!(name(info.name, info.name_len), "object");
    assert_eq!((info.part, info.is_transferred, info.map_len), (2, 0, 2));
    assert_eq!((info.has_depth, info.has_groups, info.has_clips), (0, 1, 1));
    assert_eq!((info.point_len, info.vertex_len, info.view_len), (9, 10, 3));
    assert_eq!((info.element_len, info.layer_len, info.order_len), (7, 2, 9));
    assert_eq!((info.width, info.height), (48, 40));
    let fit = [info.rms_error, info.left_out_rms, info.visibility];
    assert_eq!(fit, expected.fit().figures());
    assert_eq!(name(map.name, map.name_len), "jump");
    assert_eq!((map.part, map.parameters_len), (1, 2));

    let mut rng = Rng(3);
    let parameters = [rng.unit(), rng.unit()];
    let mut frame = FrameArrays::default();
    let mut scratch = vec![f32::NAN; map.scratch_len];
    let job = sinew_frame_job {
        views,
        map: 1,
        parameters: parameters.as_ptr(),
        parameters_len: 2,
        scratch: scratch.as_mut_ptr(),
        scratch_len: scratch.len(),
        points: frame.points.as_mut_ptr(),
        points_len: 9,
        visibility: frame.visibility.as_mut_ptr(),
        visibility_len: 9,
        scores: frame.scores.as_mut_ptr(),
        scores_len: 3,
        layers: frame.layers.as_mut_ptr(),
        layers_len: 2,
    };
    let mut found = sinew_found { view: 9, confidence: 0.0 };
    // SAFETY: a job of open views and arrays with their lengths, and a structure to be written.
    done(unsafe { sinew_views_frame(&raw const job, &raw mut found, NONE) });
    let mut own = FrameArrays::default();
    let kernel = model.map_of(&expected, 1).unwrap();
    let run = FrameJob { views: expected, map: kernel, parameters: &parameters };
    let own_found = run.run(&mut vec![0.0; map.scratch_len], &mut own.frame()).unwrap();
    assert_eq!((found.view, found.confidence), (own_found.view, own_found.confidence));
    assert_eq!(frame, own);
    assert!(frame.layers.iter().all(|[opacity, _]| *opacity > 0.0));

    let refused = |edit: &dyn Fn(&mut sinew_frame_job)| {
        let mut other = job;
        edit(&mut other);
        let mut found = found;
        // SAFETY: as above, except for the field that the call refuses.
        unsafe { sinew_views_frame(&raw const other, &raw mut found, NONE) }
    };
    assert_eq!(refused(&|job| job.views = null()), sinew_status::Null);
    assert_eq!(refused(&|job| job.layers = null_mut()), sinew_status::Null);
    assert_eq!(refused(&|job| job.map = 2), sinew_status::OutOfRange);
    assert_eq!(refused(&|job| job.points_len = 8), sinew_status::Length);
    assert_eq!(refused(&|job| job.layers_len = 1), sinew_status::Length);
    assert_eq!(refused(&|job| job.scratch_len -= 1), sinew_status::TooShort);
    assert_eq!(refused(&|job| job.scores = job.visibility), sinew_status::Overlap);
    assert_eq!(refused(&|job| job.layers = job.points.cast()), sinew_status::Overlap);
    assert_eq!(frame, own);
    drawn(views, &expected, &frame);
}

#[test]
fn layers_with_depth_have_the_bits_of_the_runtime() {
    let mut pieces = Pieces::kernels(&[KernelContent::map("walk", 51)]);
    let mut content = ViewsContent::sample(vec![0], false);
    content.layers[0].flags = Layer::DEPTH;
    pieces.add_views(&content);
    let file = pieces.bytes();
    let (loaded, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    let views = model.first::<Views>().unwrap();
    let opened = loaded.open::<sinew_views>(sinew_part_kind::Views, None, 0).unwrap();
    let info = described(opened.handle);
    assert_eq!((info.has_depth, info.has_groups, info.has_clips), (1, 1, 1));
    let mut frame = FrameArrays::default();
    let map = model.map_of(&views, 0).unwrap();
    let mut scratch = vec![0.0; views.counts().frame_scratch_len(&map.counts())];
    FrameJob { views, map, parameters: &[0.25; 2] }.run(&mut scratch, &mut frame.frame()).unwrap();
    drawn(opened.handle, &views, &frame);
}

/// Arrays that a frame fills.
#[derive(Debug, Default, PartialEq)]
struct FrameArrays {
    points: [[f32; 3]; 9],
    visibility: [f32; 9],
    scores: [f32; 3],
    layers: [[f32; 2]; 2],
}

impl FrameArrays {
    fn frame(&mut self) -> Frame<'_> {
        let Self { points, visibility, scores, layers } = self;
        Frame { points, visibility, scores, layers }
    }
}

/// Draws a frame twice: with all scratch that any job may need, and with only the scratch that this job needs.
fn drawn(handle: *const sinew_views, views: &Views<'_>, frame: &FrameArrays) {
    let FrameArrays { points, visibility, scores, layers } = frame;
    let run = RenderJob { views: *views, points, visibility, scores, layers, width: 48 };
    let mut own = vec![[9; 4]; PIXELS];
    let (mut own_depths, mut own_clips) = (vec![0.0; PIXELS], vec![0; PIXELS]);
    let mut own_group = vec![[0; 4]; PIXELS];
    let expected = run.run(
        RenderScratch {
            vertices: &mut [[0.0; 3]; 10],
            order: &mut [0; 9],
            depths: &mut own_depths,
            group: &mut own_group,
            clips: &mut own_clips,
        },
        &mut own,
    );
    let expected = expected.unwrap();
    assert!(expected.element_len > 0 && own.iter().any(|pixel| *pixel != [9; 4]));
    let least = |has: bool| if has { PIXELS } else { 0 };
    let needed = [views.has_depth(), views.has_groups(), views.has_clips()].map(least);
    for [depths_len, group_len, clips_len] in [[PIXELS; 3], needed] {
        let mut pixels = vec![[9; 4]; PIXELS];
        let (mut vertices, mut order) = ([[f32::NAN; 3]; 10], [u16::MAX; 9]);
        let (mut depths, mut clips) = (vec![f32::NAN; depths_len], vec![7; clips_len]);
        let mut group = vec![[7; 4]; group_len];
        let given = |len: usize| len > 0;
        let job = sinew_render_job {
            views: handle,
            points: points.as_ptr(),
            points_len: 9,
            visibility: visibility.as_ptr(),
            visibility_len: 9,
            scores: scores.as_ptr(),
            scores_len: 3,
            layers: layers.as_ptr(),
            layers_len: 2,
            width: 48,
            pixels: pixels.as_mut_ptr(),
            pixels_len: PIXELS,
            vertices: vertices.as_mut_ptr(),
            vertices_len: 10,
            order: order.as_mut_ptr(),
            order_len: 9,
            depths: if given(depths_len) { depths.as_mut_ptr() } else { null_mut() },
            depths_len,
            group: if given(group_len) { group.as_mut_ptr() } else { null_mut() },
            group_len,
            clips: if given(clips_len) { clips.as_mut_ptr() } else { null_mut() },
            clips_len,
        };
        let mut result = sinew_drawn { element_len: 0, flipped_len: 9 };
        // SAFETY: a job of open views and arrays with their lengths, and a structure to be written.
        done(unsafe { sinew_views_render(&raw const job, &raw mut result, NONE) });
        assert_eq!(
            (result.element_len, result.flipped_len),
            (expected.element_len, expected.flipped_len)
        );
        assert!(pixels == own);
        refused(&job, views);
        assert!(pixels == own);
    }
}

/// Changes one field of a job at a time, and checks status and argument of the refused call.
fn refused(job: &sinew_render_job, views: &Views<'_>) {
    let refused = |edit: &dyn Fn(&mut sinew_render_job)| {
        let mut other = *job;
        edit(&mut other);
        let mut error = unwritten();
        // SAFETY: as for the job, except for the field that the call refuses.
        let status = unsafe { sinew_views_render(&raw const other, null_mut(), &raw mut error) };
        (status, error.argument)
    };
    use sinew_argument as Argument;
    use sinew_status as Status;
    for (found, status, argument) in [
        (refused(&|job| job.views = null()), Status::Null, Argument::Views),
        (refused(&|job| job.pixels = null_mut()), Status::Null, Argument::Pixels),
        (refused(&|job| job.layers = null()), Status::Null, Argument::Layers),
        (refused(&|job| job.vertices = null_mut()), Status::Null, Argument::Vertices),
        (refused(&|job| job.order = null_mut()), Status::Null, Argument::Scratch),
        (refused(&|job| job.layers_len = 1), Status::Length, Argument::Layers),
        (refused(&|job| job.pixels_len -= 1), Status::Length, Argument::Pixels),
        (refused(&|job| job.vertices_len = 9), Status::Length, Argument::Vertices),
        (refused(&|job| job.order_len = 8), Status::Length, Argument::Scratch),
        (refused(&|job| job.order = job.pixels.cast()), Status::Overlap, Argument::Pixels),
        (refused(&|job| job.pixels = job.vertices.cast()), Status::Overlap, Argument::Pixels),
        (refused(&|job| job.vertices = job.points.cast_mut()), Status::Overlap, Argument::Vertices),
        (
            refused(&|job| {
                (job.clips, job.clips_len) = (job.layers.cast_mut().cast(), 1);
            }),
            Status::Overlap,
            Argument::Clips,
        ),
        (
            refused(&|job| {
                (job.group, job.group_len) = (job.layers.cast_mut().cast(), 1);
            }),
            Status::Overlap,
            Argument::Group,
        ),
    ] {
        assert_eq!(found, (status, argument));
    }
    if views.has_depth() {
        let found = refused(&|job| job.depths_len = PIXELS - 1);
        assert_eq!(found, (Status::TooShort, Argument::Depths));
    }
    assert!(views.has_clips() && views.has_groups());
    assert_eq!(refused(&|job| job.group_len = PIXELS - 1), (Status::TooShort, Argument::Group));
    assert_eq!(refused(&|job| job.clips_len = PIXELS - 1), (Status::TooShort, Argument::Clips));
}
