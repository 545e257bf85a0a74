//! Views: what they say of themselves, the runtime's bits, and calls that are refused.

use crate::handles::{Loaded, NONE, done, name};
use models::{Pieces, Rng};
use sinew_capi::*;
use sinew_runtime::views::Order;
use sinew_runtime::{Frame, FrameJob, Model, RenderJob};
use std::ptr::{null, null_mut};

fn opened(loaded: &Loaded, memory: &mut [usize]) -> *const sinew_views {
    let mut views = null();
    let bytes = size_of_val(memory);
    let at = memory.as_mut_ptr().cast();
    // SAFETY: a loaded model, no name, memory with its length, and a handle to be written.
    done(unsafe { sinew_views_open(loaded.handle, null(), 0, 0, at, bytes, &raw mut views, NONE) });
    views
}

#[test]
fn views_are_described_and_drawn_with_the_bits_of_the_runtime() {
    let [file, _] = Pieces::viewed().map(|pieces| pieces.bytes());
    let (loaded, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    let expected = model.views().unwrap();
    let mut memory = [0; SINEW_VIEWS_WORDS];
    let views = opened(&loaded, &mut memory);
    let mut info = std::mem::MaybeUninit::<sinew_views_info>::uninit();
    let mut map = std::mem::MaybeUninit::<sinew_map_info>::uninit();
    // SAFETY: open views and structures to be written.
    let (info, map) = unsafe {
        done(sinew_views_describe(views, info.as_mut_ptr(), NONE));
        done(sinew_views_map(views, 1, map.as_mut_ptr(), NONE));
        (info.assume_init(), map.assume_init())
    };
    assert_eq!(name(info.name, info.name_len), "object");
    assert_eq!((info.part, info.is_transferred, info.map_len), (2, 0, 2));
    assert_eq!((info.point_len, info.element_len, info.view_len), (9, 6, 3));
    let fit = [info.margin, info.rms_error, info.left_out_rms, info.visibility];
    assert_eq!(fit, expected.fit().figures());
    assert_eq!(name(map.name, map.name_len), "jump");
    assert_eq!((map.part, map.parameters_len), (1, 2));

    let mut rng = Rng(3);
    let parameters = [rng.unit(), rng.unit()];
    let (mut points, mut visibility, mut scores) = ([[0.0; 3]; 9], [0.0; 9], [0.0; 3]);
    let mut scratch = vec![f32::NAN; map.scratch_len];
    let job = sinew_frame_job {
        views,
        map: 1,
        parameters: parameters.as_ptr(),
        parameters_len: 2,
        last_view: 2,
        has_last: 1,
        margin: info.margin,
        scratch: scratch.as_mut_ptr(),
        scratch_len: scratch.len(),
        points: points.as_mut_ptr(),
        points_len: 9,
        visibility: visibility.as_mut_ptr(),
        visibility_len: 9,
        scores: scores.as_mut_ptr(),
        scores_len: 3,
    };
    let mut found = sinew_found { view: 9, confidence: 0.0 };
    // SAFETY: a job of open views and arrays with their lengths, and a structure to be written.
    done(unsafe { sinew_views_frame(&raw const job, &raw mut found, NONE) });
    let mut own = ([[0.0; 3]; 9], [0.0; 9], [0.0; 3]);
    let frame = Frame { points: &mut own.0, visibility: &mut own.1, scores: &mut own.2 };
    let kernel = model.map_of(&expected, 1).unwrap();
    let run = FrameJob {
        views: expected,
        map: kernel,
        parameters: &parameters,
        last: Some(2),
        margin: info.margin,
    };
    let told = run.run(&mut vec![0.0; map.scratch_len], frame).unwrap();
    assert_eq!((found.view, found.confidence), (told.view, told.confidence));
    assert_eq!((points, visibility, scores), own);

    let refused = |edit: &dyn Fn(&mut sinew_frame_job)| {
        let mut other = job;
        edit(&mut other);
        let mut found = found;
        // SAFETY: as above, but for what the call refuses.
        unsafe { sinew_views_frame(&raw const other, &raw mut found, NONE) }
    };
    assert_eq!(refused(&|job| job.views = null()), sinew_status::Null);
    assert_eq!(refused(&|job| job.map = 2), sinew_status::OutOfRange);
    assert_eq!(refused(&|job| job.last_view = 3), sinew_status::OutOfRange);
    assert_eq!(refused(&|job| job.points_len = 8), sinew_status::Length);
    assert_eq!(refused(&|job| job.scratch_len -= 1), sinew_status::TooShort);
    assert_eq!(refused(&|job| job.scores = job.visibility), sinew_status::Overlap);
    assert_eq!((points, visibility, scores), own);
    drawn(views, &expected, (&points, &visibility, &scores), found.view);
}

/// Draws in both orders.
fn drawn(
    handle: *const sinew_views,
    views: &sinew_runtime::Views<'_>,
    (points, visibility, scores): (&[[f32; 3]; 9], &[f32; 9], &[f32; 3]),
    view: usize,
) {
    let run = RenderJob { views: *views, points, visibility, scores, view, width: 48 };
    for has_depths in [false, true] {
        let mut pixels = vec![[9; 4]; 48 * 40];
        let mut depths = vec![f32::INFINITY; 48 * 40];
        let mut order = [0; 6];
        let job = sinew_render_job {
            views: handle,
            points: points.as_ptr(),
            points_len: 9,
            visibility: visibility.as_ptr(),
            visibility_len: 9,
            scores: scores.as_ptr(),
            scores_len: 3,
            view,
            width: 48,
            pixels: pixels.as_mut_ptr(),
            pixels_len: pixels.len(),
            depths: if has_depths { depths.as_mut_ptr() } else { null_mut() },
            depths_len: if has_depths { depths.len() } else { 0 },
            order: order.as_mut_ptr(),
            order_len: 6,
        };
        let mut told = sinew_drawn { element_len: 0, flipped_len: 9 };
        // SAFETY: a job of open views and arrays with their lengths, and a structure to be written.
        done(unsafe { sinew_views_render(&raw const job, &raw mut told, NONE) });
        let mut own = vec![[9; 4]; 48 * 40];
        let (mut own_depths, mut own_order) = (vec![f32::INFINITY; 48 * 40], [0; 6]);
        let by =
            if has_depths { Order::Depth(&mut own_depths) } else { Order::Painter(&mut own_order) };
        let expected = run.run(by, &mut own).unwrap();
        assert_eq!(
            (told.element_len, told.flipped_len),
            (expected.element_len, expected.flipped_len)
        );
        assert!(
            pixels == own && depths == own_depths && pixels.iter().any(|pixel| *pixel != [9; 4])
        );
        let refused = |edit: &dyn Fn(&mut sinew_render_job)| {
            let mut other = job;
            edit(&mut other);
            // SAFETY: as above, but for what the call refuses.
            unsafe { sinew_views_render(&raw const other, null_mut(), NONE) }
        };
        assert_eq!(refused(&|job| job.view = 3), sinew_status::OutOfRange);
        assert_eq!(refused(&|job| job.pixels_len -= 1), sinew_status::Length);
        assert_eq!(refused(&|job| job.pixels = null_mut()), sinew_status::Null);
        assert_eq!(refused(&|job| job.order = job.pixels.cast()), sinew_status::Overlap);
        if !has_depths {
            assert_eq!(refused(&|job| job.order_len = 5), sinew_status::Length);
        }
        assert!(pixels == own);
    }
}
