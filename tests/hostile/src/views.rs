//! Evaluates and draws views of an accepted file and checks the promises of the runtime.

use crate::parts::query;
use sinew_runtime::views::{CLIPS_MAX, Drawn, RenderScratch};
use sinew_runtime::{Argument, CallErrorKind, Frame, FrameJob, Model, RenderJob, Views};

/// Width and height of a picture.
const SIZE: [usize; 2] = [24, 16];

/// Cost above which a picture would take too long. Counted are drawn elements (elements of a
/// clipping layer once for each layer that they clip); weights; and points, vertices and layers
/// times key views.
const COST: usize = 1 << 14;

/// Reads every accessor of views.
///
/// # Panics
/// If an accessor lacks a value that loaded views must have, or if the views ask for more than
/// their file's length allows.
pub(crate) fn read_views<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>) {
    let file = model.as_bytes();
    let (k, v, e) = (views.point_len(), views.vertex_len(), views.element_len());
    let (l, n, counts) = (views.layer_len(), views.view_len(), views.counts());
    let lens = [k, v, e, l, n, views.order_len(), counts.result_len()];
    let others = [counts.weight_len, counts.texel_len, counts.map_len].map(|len| len as usize);
    for cost in lens.into_iter().chain(others) {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    assert!((0..n).all(|view| views.view_name(view).is_some()));
    read_layers(views);
    read_vertices(views);
    let has_vertices = |element| {
        views
            .element(element)
            .is_some_and(|element| element.vertices().iter().all(|vertex| *vertex < v))
    };
    let is_met = |element| {
        views
            .neighbours(element)
            .is_some_and(|others| others.iter().flatten().all(|other| *other < e))
    };
    assert!((0..e).all(|element| has_vertices(element) && is_met(element)));
    // A key view may lack a layer.
    let is_textured = |view, layer| {
        let texture = views.view_texture(view, layer);
        texture.is_none_or(|texture| views.texture(texture).is_some())
    };
    assert!(l * n > COST || (0..n).all(|view| (0..l).all(|layer| is_textured(view, layer))));
    let finite = |place: Option<[f32; 2]>| place.is_some_and(|p| p.iter().all(|x| x.is_finite()));
    let stands = |view, vertex| finite(views.texel(view, vertex));
    assert!(v * n > COST || (0..n).all(|view| (0..v).all(|vertex| stands(view, vertex))));
    let is_there = |view, point| {
        views.is_visible(view, point).is_some()
            && finite(views.reference(view, point))
            && finite(views.offset(view, point)) == views.is_transferred()
    };
    assert!(k * n > COST || (0..n).all(|view| (0..k).all(|point| is_there(view, point))));
    for map in 0..counts.map_len as usize {
        assert!(
            model.map_of(views, map).is_some_and(|map| map.result_len() == counts.result_len())
        );
    }
    let opened = views.layout().open::<Views>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == counts));
}

/// Reads the layers: each element belongs to one layer, and chains of clipping layers have no
/// cycle.
fn read_layers(views: &Views<'_>) {
    let l = views.layer_len();
    let (mut end, mut has_depth, mut has_clips, mut has_groups) = (0, false, false, false);
    for number in 0..l {
        let layer = views.layer(number).expect("a layer by its number");
        assert!(views.layer_name(number).is_some());
        assert!(layer.first == end && layer.end >= end, "layer {number}: {layer:?}");
        assert!(layer.clip.is_none_or(|clip| clip < l && clip != number));
        assert!(
            views.clips(number).count() < CLIPS_MAX
                || views.clips(number).all(|clip| clip != number)
        );
        end = layer.end;
        has_depth |= layer.has_depth;
        has_clips |= layer.clip.is_some();
        has_groups |= layer.is_group;
    }
    assert_eq!(end, views.element_len());
    assert_eq!((has_depth, has_clips), (views.has_depth(), views.has_clips()));
    assert_eq!(has_groups || has_clips, views.has_groups());
    assert!(views.layer(l).is_none() && views.layer_name(l).is_none());
}

/// Reads the vertices: each weight belongs to one vertex and one point.
fn read_vertices(views: &Views<'_>) {
    let mut weight_len = 0;
    for number in 0..views.vertex_len() {
        let vertex = views.vertex(number).expect("a vertex by its number");
        assert!(vertex.place().iter().all(|x| x.is_finite()));
        assert!(vertex.point().is_none_or(|point| point < views.point_len()));
        for (point, weight) in vertex.weights() {
            assert!(point < views.point_len() && weight.iter().all(|x| x.is_finite()));
            weight_len += 1;
        }
    }
    assert_eq!(weight_len, views.counts().weight_len as usize);
    assert!(views.vertex(views.vertex_len()).is_none());
}

/// Counts the elements that a picture draws: those of every layer, and again those of the layers
/// that clip it. Each layer counts as one more element, because a pass runs over its pixels.
fn picture_cost(views: &Views<'_>) -> usize {
    let len = |layer| views.layer(layer).map_or(0, |layer| layer.end - layer.first);
    let layers = 0..views.layer_len();
    let costs = layers.map(|layer| {
        let clips = views.clips(layer).map(|clip| 1 + len(clip));
        1 + len(layer) + clips.sum::<usize>()
    });
    costs.sum()
}

/// Evaluates query `number` with each map, and draws the resulting frame.
///
/// # Panics
/// If a call is refused for another reason than overflow, if a refused call has written, if a
/// result is not finite, or if a picture depends on the previous content of scratch.
pub(crate) fn evaluate_views<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>, number: usize) {
    let (k, n, l) = (views.point_len(), views.view_len(), views.layer_len());
    let (v, counts) = (views.vertex_len(), views.counts());
    let costs = [k * n, v * n, l * n, counts.weight_len as usize, picture_cost(views)];
    if costs.into_iter().any(|cost| cost > COST) {
        return;
    }
    for map in (0..counts.map_len as usize).filter_map(|map| model.map_of(views, map)) {
        let (mut points, mut visibility) = (vec![[f32::NAN; 3]; k], vec![f32::NAN; k]);
        let (mut scores, mut layers) = (vec![f32::NAN; n], vec![[f32::NAN; 2]; l]);
        let job = FrameJob { views: *views, map, parameters: &query(&map, number) };
        let mut out = Frame {
            points: &mut points,
            visibility: &mut visibility,
            scores: &mut scores,
            layers: &mut layers,
        };
        let mut scratch = vec![f32::NAN; counts.frame_scratch_len(&map.counts())];
        let found = job.run(&mut scratch, &mut out);
        let all = points.as_flattened().iter().chain(&visibility).chain(&scores);
        let mut all = all.chain(layers.as_flattened()).copied();
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                assert!(all.all(f32::is_nan), "{error}: written");
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
        assert!(all.all(f32::is_finite));
        assert!(layers.iter().all(|[opacity, _]| (0.0..=1.0).contains(opacity)));
        let [width, _] = SIZE;
        let job = RenderJob {
            views: *views,
            points: &points,
            visibility: &visibility,
            scores: &scores,
            layers: &layers,
            width,
        };
        let (drawn, pixels) = picture(&job, (f32::NAN, u16::MAX, u8::MAX));
        assert!(drawn.flipped_len <= drawn.element_len && drawn.element_len <= views.element_len());
        assert!((drawn, pixels) == picture(&job, (0.0, 0, 0)), "{number}: scratch is seen");
        let hidden = vec![[0.0; 2]; l];
        let (drawn, pixels) = picture(&RenderJob { layers: &hidden, ..job }, (1.0, 1, 1));
        assert!(drawn == Drawn::default() && pixels.iter().all(|pixel| *pixel == [0; 4]));
    }
}

/// Draws a picture with the minimum scratch of the job, filled with a float, numbers and bytes.
///
/// # Panics
/// If the job is refused.
fn picture(job: &RenderJob<'_>, (float, half, byte): (f32, u16, u8)) -> (Drawn, Vec<[u8; 4]>) {
    let views = &job.views;
    let [width, height] = SIZE;
    let mut pixels = vec![[0; 4]; width * height];
    let len = |is_asked: bool| if is_asked { pixels.len() } else { 0 };
    let [depth_len, group_len, clip_len] =
        [views.has_depth(), views.has_groups(), views.has_clips()].map(len);
    let scratch = RenderScratch {
        vertices: &mut vec![[float; 3]; views.vertex_len()],
        order: &mut vec![half; views.order_len()],
        depths: &mut vec![float; depth_len],
        group: &mut vec![[byte; 4]; group_len],
        clips: &mut vec![byte; clip_len],
    };
    match job.run(scratch, &mut pixels) {
        Ok(drawn) => (drawn, pixels),
        Err(error) => panic!("{error}"),
    }
}
