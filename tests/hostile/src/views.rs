//! Views of an accepted file, evaluated, drawn and held to what the runtime promises.

use crate::kernels::query;
use sinew_runtime::views::Order;
use sinew_runtime::{Argument, CallErrorKind, Frame, FrameJob, Model, RenderJob, Views};

/// Width and height of a picture.
const SIZE: [usize; 2] = [24, 16];

/// Elements, and points times key views, that are worth a picture's time.
const COST: usize = 1 << 14;

/// Reads all that the accessors of views give.
///
/// # Panics
/// Where one lacks what loaded views must have, or where they ask for more than a file of their length may.
pub(crate) fn read_views<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>) {
    let file = model.as_bytes();
    let (k, n, counts) = (views.point_len(), views.view_len(), views.counts());
    for cost in [k, n, views.element_len(), counts.result_len(), counts.texel_len as usize] {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    let has_points = |element| {
        views
            .element(element)
            .is_some_and(|element| element.points().iter().all(|point| *point < k))
    };
    assert!((0..views.element_len()).all(has_points));
    assert!((0..n).all(|view| views.view_name(view).is_some()));
    let is_textured =
        |view| views.view_texture(view).is_some_and(|texture| views.texture(texture).is_some());
    assert!((0..n).all(is_textured));
    let is_there = |view, point| {
        let finite =
            |place: Option<[f32; 2]>| place.is_some_and(|p| p.iter().all(|x| x.is_finite()));
        finite(views.reference(view, point))
            && views.is_visible(view, point).is_some()
            && finite(views.offset(view, point)) == views.is_transferred()
    };
    assert!(k * n > COST || (0..n).all(|view| (0..k).all(|point| is_there(view, point))));
    for map in 0..counts.map_len as usize {
        assert!(
            model.map_of(views, map).is_some_and(|map| map.result_len() == counts.result_len())
        );
    }
    let opened = views.layout().open(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Evaluates a query by its number with each map, and draws what comes of it.
///
/// # Panics
/// Where a call is refused but for what is beyond measure, where a refused call has written, or where a result is not
/// finite.
pub(crate) fn evaluate_views<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>, number: usize) {
    let (k, n, e) = (views.point_len(), views.view_len(), views.element_len());
    let counts = views.counts();
    if e > COST || k * n > COST {
        return;
    }
    for map in (0..counts.map_len as usize).filter_map(|map| model.map_of(views, map)) {
        let (mut points, mut visibility) = (vec![[f32::NAN; 3]; k], vec![f32::NAN; k]);
        let mut scores = vec![f32::NAN; n];
        let job = FrameJob {
            views: *views,
            map,
            parameters: &query(&map, number),
            last: (number % 2 == 1).then_some(number % n),
            margin: [0.0, 0.25, 1e6, f32::MAX][number % 4],
        };
        let out = Frame { points: &mut points, visibility: &mut visibility, scores: &mut scores };
        let mut scratch = vec![f32::NAN; counts.frame_scratch_len(&map.counts())];
        let found = match job.run(&mut scratch, out) {
            Ok(found) => found,
            Err(error) => {
                let all = points.as_flattened().iter().chain(&visibility).chain(&scores);
                assert!(all.copied().all(f32::is_nan), "{error}: written");
                let of = match error.kind {
                    CallErrorKind::NonFinite => &[Argument::Outputs, Argument::Points][..],
                    CallErrorKind::ZeroRotation => &[Argument::Query],
                    _ => &[],
                };
                assert!(of.contains(&error.argument), "{error}");
                continue;
            }
        };
        assert!(found.view < n && (0.0..=1.0).contains(&found.confidence));
        let mut all = points.as_flattened().iter().chain(&visibility).chain(&scores);
        assert!(all.all(|x| x.is_finite()));
        let [width, height] = SIZE;
        let job = RenderJob {
            views: *views,
            points: &points,
            visibility: &visibility,
            scores: &scores,
            view: found.view,
            width,
        };
        let mut pixels = vec![[0; 4]; width * height];
        let mut depths = vec![f32::INFINITY; width * height];
        let by_depth = job.run(Order::Depth(&mut depths), &mut pixels);
        let painted = job.run(Order::Painter(&mut vec![u16::MAX; e]), &mut pixels);
        assert!(by_depth.is_ok_and(|drawn| drawn.flipped_len <= drawn.element_len));
        assert_eq!(by_depth, painted, "{number}");
    }
}
