//! Objects of key views: frames against the formulas in f64, and pictures against their textures.

use models::{KernelContent, Pieces, ViewsContent};
use sinew_runtime::views::{Drawn, Found, Order};
use sinew_runtime::{
    Argument, CallError, CallErrorKind as Kind, Frame, FrameJob, Model, RenderJob, Views,
};

/// A frame of the sample.
#[derive(Clone, Debug, PartialEq)]
struct Written {
    points: [[f32; 3]; 9],
    visibility: [f32; 9],
    scores: [f32; 3],
}

const NOTHING: Written =
    Written { points: [[f32::MAX; 3]; 9], visibility: [f32::MAX; 9], scores: [f32::MAX; 3] };

fn file(content: &ViewsContent, map: &KernelContent) -> Model<Vec<u8>> {
    let mut pieces = Pieces::kernels(std::slice::from_ref(map));
    pieces.add_views(content);
    Model::from_bytes(pieces.bytes()).unwrap()
}

fn sample(is_transferred: bool) -> Model<Vec<u8>> {
    file(&ViewsContent::sample(vec![0], is_transferred), &KernelContent::map("walk", 51))
}

fn frame(
    model: &Model<Vec<u8>>,
    parameters: &[f32],
    (last, margin): (Option<usize>, f32),
) -> (Result<Found, CallError>, Written) {
    let views = model.views().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    let mut out = NOTHING;
    let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
    let Written { points, visibility, scores } = &mut out;
    let found = FrameJob { views, map, parameters, last, margin }
        .run(&mut scratch, Frame { points, visibility, scores });
    (found, out)
}

/// What the map itself gives.
fn outputs(model: &Model<Vec<u8>>, parameters: &[f32]) -> Vec<f32> {
    let map = model.kernel().unwrap();
    let mut out = vec![0.0; map.result_len()];
    map.evaluate(parameters, &mut vec![0.0; map.counts().scratch_len()], &mut out).unwrap();
    out
}

#[test]
fn a_frame_is_what_its_map_gives() {
    let model = sample(false);
    for parameters in [[0.0, 0.0], [0.75, -0.5], [-1.0, 1.25]] {
        let (found, out) = frame(&model, &parameters, (None, 0.25));
        let expected = outputs(&model, &parameters);
        let all = [out.points.as_flattened(), &out.visibility, &out.scores].concat();
        assert_eq!(all, expected);
        let best = (0..3).max_by(|a, b| out.scores[*a].total_cmp(&out.scores[*b]));
        assert_eq!(Some(found.unwrap().view), best);
    }
}

/// A map whose scores alone depend on the first number: 0, x and 2 x - 1, which cross at 0 and at 1.
fn crossing() -> KernelContent {
    let mut map = KernelContent::map("walk", 51);
    for (value, row) in map.coefficients.iter_mut().enumerate() {
        row[..6].fill(0.0);
        row[7..].fill(0.0);
        match value.checked_sub(36) {
            None => {}
            Some(0) => row[6] = 0.0,
            Some(1) => (row[6], row[7]) = (0.0, 1.0),
            Some(_) => (row[6], row[7]) = (-1.0, 2.0),
        }
    }
    map
}

#[test]
fn a_view_stays_until_another_is_ahead_by_the_margin() {
    let model = file(&ViewsContent::sample(vec![0], false), &crossing());
    let steps: Vec<f32> = (-32..=64).map(|step| step as f32 / 32.0).collect();
    let mut last = None;
    let mut switches = Vec::new();
    for x in steps.iter().chain(steps.iter().rev()) {
        let view = frame(&model, &[*x, 0.0], (last, 0.25)).0.unwrap().view;
        if last.is_some_and(|last| last != view) {
            switches.push((*x, view));
        }
        last = Some(view);
    }
    let step = 1.0 / 32.0;
    let expected = [(0.25 + step, 1), (1.25 + step, 2), (0.75 - step, 1), (-0.25 - step, 0)];
    assert_eq!(switches, expected);
    // Without a margin, and of a first frame, the highest; of equal ones the first.
    for (last, margin, x, view) in [
        (Some(0), 0.0, 0.125, 1),
        (None, 9.0, 0.125, 1),
        (None, 0.25, 1.0, 1),
        (Some(2), 0.0, 1.0, 2),
    ] {
        assert_eq!(frame(&model, &[x, 0.0], (last, margin)).0.unwrap().view, view);
    }
}

#[test]
fn what_is_transferred_moves_as_the_formula_says() {
    let content = ViewsContent::sample(vec![0], true);
    let model = sample(true);
    let mut between = 0;
    for number in 0..60 {
        let parameters = [number as f32 / 20.0 - 1.5, 0.25];
        let margin = 0.5;
        let plain = outputs(&model, &parameters);
        let scores: Vec<f64> = plain[36..].iter().map(|x| f64::from(*x)).collect();
        let highest = scores.iter().copied().fold(f64::MIN, f64::max);
        let shares = scores.iter().map(|score| {
            let u = (1.0 - (highest - score) / margin).max(0.0);
            u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        });
        let shares: Vec<f64> = shares.collect();
        between += usize::from(shares.iter().filter(|share| **share > 0.01).count() > 1);
        let whole: f64 = shares.iter().sum();
        let mean = |at: &dyn Fn(usize) -> f64| -> f64 {
            shares.iter().enumerate().map(|(view, share)| share / whole * at(view)).sum()
        };
        let deformation = |view: usize| content.views[view].deformation.as_ref().unwrap();
        let ratio = mean(&|view| deformation(view).0.into());
        let (_, out) = frame(&model, &parameters, (None, margin as f32));
        for axis in 0..2 {
            let places: Vec<f64> = (0..9).map(|k| plain[3 * k + axis].into()).collect();
            let centre = places.iter().sum::<f64>() / 9.0;
            for (k, place) in places.iter().enumerate() {
                let offset = mean(&|view| deformation(view).1[k][axis].into());
                let expected = ratio * (place - centre) + offset + centre;
                assert!((f64::from(out.points[k][axis]) - expected).abs() < 1e-4);
            }
        }
        assert!((0..9).all(|k| out.points[k][2] == plain[3 * k + 2]));
    }
    assert!(between > 10);
}

#[test]
fn what_is_transferred_onto_itself_keeps_its_bits() {
    let mut content = ViewsContent::sample(vec![0], true);
    for view in &mut content.views {
        view.deformation = Some((1.0, vec![[0.0; 2]; 9]));
    }
    let (itself, plain) = (file(&content, &KernelContent::map("walk", 51)), sample(false));
    for number in 0..50 {
        let parameters = [number as f32 / 20.0 - 1.2, 0.5];
        assert_eq!(
            frame(&itself, &parameters, (None, 1.0)),
            frame(&plain, &parameters, (None, 1.0))
        );
    }
}

#[test]
fn no_switch_of_views_is_seen() {
    let mut map = crossing();
    // Only the scores move: what else moves is the switch.
    map.coefficients[0][7] = 0.0;
    let model = file(&ViewsContent::sample(vec![0], true), &map);
    let farthest = |margin: f32| {
        let (mut last, mut before, mut most, mut switched) = (None, None, 0.0f32, 0);
        for step in 0..4000 {
            let x = (step as f32 - 1000.0) / 1000.0;
            let (found, out) = frame(&model, &[x, 0.0], (last, margin));
            let view = found.unwrap().view;
            switched += usize::from(last.is_some_and(|last| last != view));
            last = Some(view);
            let points = out.points.map(|[x, y, _]| [x, y]);
            if let Some(before) = before.replace(points) {
                let apart = before.as_flattened().iter().zip(points.as_flattened());
                most = apart.map(|(a, b): (&f32, &f32)| (a - b).abs()).fold(most, f32::max);
            }
        }
        assert_eq!(switched, 2);
        most
    };
    let [smooth, sudden] = [0.5, 0.0].map(farthest);
    assert!(smooth < 0.05 && sudden > 1.0, "{smooth} {sudden}");
}

#[test]
fn at_the_prototypes_reference_the_instance_has_its_own() {
    // A map that gives one configuration whatever it is asked for.
    let map = crossing();
    let reference = [[3.0, 1.0], [9.0, 2.0], [17.0, 0.0], [2.0, 9.0], [10.0, 8.0], [15.0, 9.0]];
    let reference: Vec<[f32; 2]> =
        reference.into_iter().chain([[2.0, 19.0], [9.0, 17.0], [18.0, 18.0]]).collect();
    let model = file(&ViewsContent::sample(vec![0], false), &map);
    let (_, plain) = frame(&model, &[0.0, 0.0], (None, 0.0));
    let mean = |places: &[[f32; 2]], axis: usize| {
        places.iter().map(|place| place[axis]).sum::<f32>() / 9.0
    };
    let prototype = plain.points.map(|[x, y, _]| [x, y]);
    for ratio in [1.0, 1.75] {
        let offset = |k: usize| {
            [0, 1].map(|axis| {
                let own = reference[k][axis] - mean(&reference, axis);
                own - ratio * (prototype[k][axis] - mean(&prototype, axis))
            })
        };
        let mut content = ViewsContent::sample(vec![0], true);
        for view in &mut content.views {
            view.deformation = Some((ratio, (0..9).map(offset).collect()));
        }
        let (_, out) = frame(&file(&content, &map), &[0.0, 0.0], (None, 0.25));
        for (point, own) in out.points.iter().zip(&reference) {
            for axis in 0..2 {
                let expected = own[axis] - mean(&reference, axis) + mean(&prototype, axis);
                assert!((point[axis] - expected).abs() < 1e-5);
            }
        }
    }
}

/// A job that shows a key view as it is.
fn shown<'a>(views: Views<'a>, view: usize, points: &'a [[f32; 3]; 9]) -> RenderJob<'a> {
    RenderJob { views, points, visibility: &[1.0; 9], scores: &[0.0; 3], view, width: 12 }
}

/// The points of a key view where its texture has them.
fn references(views: &Views<'_>, view: usize) -> [[f32; 3]; 9] {
    std::array::from_fn(|point| {
        let [x, y] = views.reference(view, point).unwrap();
        [x, y, 0.0]
    })
}

fn painted(job: &RenderJob<'_>) -> (Drawn, Vec<[u8; 4]>) {
    let mut pixels = vec![[0; 4]; 120];
    let drawn = job.run(Order::Painter(&mut [u16::MAX; 6]), &mut pixels).unwrap();
    (drawn, pixels)
}

/// A texel of a texture, times its alpha; nothing beyond it.
fn texel(views: &Views<'_>, texture: usize, x: usize, y: usize) -> [f64; 4] {
    let texture = views.texture(texture).unwrap();
    let [width, _] = texture.size();
    let [r, g, b, a] = texture.texels()[y * width + x].map(f64::from);
    [r * a / 255.0, g * a / 255.0, b * a / 255.0, a]
}

#[test]
fn a_key_view_renders_to_its_own_texture() {
    let model = sample(false);
    let views = model.views().unwrap();
    for (view, texture) in [(0, 0), (1, 1), (2, 0)] {
        let points = references(&views, view);
        let mut content = ViewsContent::sample(vec![0], false);
        content.views.iter_mut().for_each(|view| view.visible.fill(true));
        let model = file(&content, &KernelContent::map("walk", 51));
        let views = model.views().unwrap();
        let (drawn, pixels) = painted(&shown(views, view, &points));
        assert_eq!(drawn, Drawn { element_len: 6, flipped_len: 0 });
        let mut seen = 0;
        for (at, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            for (found, expected) in pixel.iter().zip(texel(&views, texture, at % 12, at / 12)) {
                assert!((f64::from(*found) - expected).abs() <= 1.0, "{view} {at}");
            }
            seen += 1;
        }
        assert!(seen >= 28, "{seen}");
    }
}

#[test]
fn what_a_view_does_not_show_has_the_texture_of_one_that_does() {
    let model = sample(false);
    let views = model.views().unwrap();
    // View 1 hides point 8, of the last element alone; view 2, of the texture of view 0, hides point 0.
    let points = references(&views, 1);
    let job = shown(views, 1, &points);
    let (_, other) = painted(&job);
    let (_, left) = painted(&RenderJob { scores: &[0.5, 1.0, 0.25], ..job });
    let (_, right) = painted(&RenderJob { scores: &[0.25, 1.0, 0.5], ..job });
    let differ = |a: &[[u8; 4]], b: &[[u8; 4]]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    // Where none shows it better, the first of equals: 0.
    assert_eq!((differ(&other, &left), differ(&left, &right)), (0, 0));
    let mut content = ViewsContent::sample(vec![0], false);
    content.views[1].visible.fill(true);
    let model = file(&content, &KernelContent::map("walk", 51));
    let (_, own) = painted(&RenderJob { views: model.views().unwrap(), ..job });
    let within = (4..8).flat_map(|y| (3..7).map(move |x| 12 * y + x));
    assert!(differ(&own, &left) > 4 && within.clone().any(|at| own[at] != left[at]));
    let elsewhere = own.iter().zip(&left).enumerate().filter(|(at, _)| at / 12 < 4);
    assert!(elsewhere.into_iter().all(|(_, (own, left))| own == left));
}

#[test]
fn what_has_a_hidden_point_is_not_drawn() {
    let model = sample(false);
    let views = model.views().unwrap();
    let points = references(&views, 0);
    let mut visibility = [1.0; 9];
    visibility[0] = 0.5;
    let (drawn, pixels) =
        painted(&RenderJob { visibility: &visibility, ..shown(views, 0, &points) });
    assert_eq!(drawn.element_len, 5);
    // The quad of point 0 is the first quarter.
    assert_eq!((pixels[2 * 12 + 2], pixels[3 * 12 + 4]), ([0; 4], [0; 4]));
    assert_ne!(pixels[2 * 12 + 8], [0; 4]);
}

#[test]
fn painters_start_with_the_farthest() {
    // The triangles 1 2 5 and 7 6 3, one over the other, of textures without alpha.
    let mut content = ViewsContent::sample(vec![0], false);
    content.textures.iter_mut().flat_map(|t| &mut t.texels).for_each(|texel| texel[3] = 255);
    let model = file(&content, &KernelContent::map("walk", 51));
    let views = model.views().unwrap();
    let mut points = [[0.0, 0.0, 0.0]; 9];
    for corners in [[1, 2, 5], [7, 6, 3]] {
        for (corner, place) in corners.into_iter().zip([[0.0, 0.0], [12.0, 0.0], [12.0, 10.0]]) {
            points[corner] = [place[0], place[1], 0.0];
        }
    }
    let mut visibility = [0.0; 9];
    [1, 2, 5, 7, 6, 3].into_iter().for_each(|point| visibility[point] = 1.0);
    let mut picture = |depth: f32| {
        [7, 6, 3].into_iter().for_each(|point: usize| points[point][2] = depth);
        let (drawn, pixels) =
            painted(&RenderJob { visibility: &visibility, ..shown(views, 0, &points) });
        assert_eq!(drawn.element_len, 2);
        pixels
    };
    let [far, same, near] = [1.0, 0.0, -1.0].map(&mut picture);
    assert!(far != same && same == near);
}

#[test]
fn refused_calls_have_written_nothing() {
    let model = sample(true);
    let views = model.views().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    let error = |kind, argument, index, [expected, found]: [usize; 2]| CallError {
        kind,
        argument,
        index,
        expected,
        found,
    };
    for (parameters, before, expected) in [
        (vec![0.0; 3], (None, 0.0), error(Kind::Length, Argument::Query, 0, [2, 3])),
        (vec![0.0, f32::NAN], (None, 0.0), error(Kind::NonFinite, Argument::Query, 1, [0; 2])),
        (vec![0.0; 2], (Some(3), 0.0), error(Kind::OutOfRange, Argument::Scores, 0, [2, 3])),
        (vec![0.0; 2], (None, -0.5), error(Kind::OutOfRange, Argument::Scores, 0, [2, 3])),
        (vec![0.0; 2], (None, f32::NAN), error(Kind::OutOfRange, Argument::Scores, 0, [2, 3])),
        (vec![1e38; 2], (None, 0.0), error(Kind::NonFinite, Argument::Points, 0, [0; 2])),
        (vec![3e38; 2], (None, 0.0), error(Kind::NonFinite, Argument::Outputs, 0, [0; 2])),
    ] {
        let (found, out) = frame(&model, &parameters, before);
        assert_eq!((found.map_err(|error| error.kind), out), (Err(expected.kind), NOTHING));
        assert_eq!(frame(&model, &parameters, before).0.unwrap_err().argument, expected.argument);
    }
    let least = views.counts().frame_scratch_len(&map.counts());
    for (lens, expected) in [
        ([8, 9, 3, least], error(Kind::Length, Argument::Points, 0, [9, 8])),
        ([9, 10, 3, least], error(Kind::Length, Argument::Visibility, 0, [9, 10])),
        ([9, 9, 2, least], error(Kind::Length, Argument::Scores, 0, [3, 2])),
        ([9, 9, 3, least - 1], error(Kind::TooShort, Argument::Scratch, 0, [least, least - 1])),
    ] {
        let [mut points, mut visibility, mut scores] =
            [lens[0], lens[1], lens[2]].map(|len| vec![[f32::MAX; 3]; len]);
        let frame = Frame {
            points: &mut points,
            visibility: &mut visibility.as_flattened_mut()[..lens[1]],
            scores: &mut scores.as_flattened_mut()[..lens[2]],
        };
        let job = FrameJob { views, map, parameters: &[0.0; 2], last: None, margin: 0.0 };
        assert_eq!(job.run(&mut vec![0.0; lens[3]], frame), Err(expected));
        let all = [points, visibility, scores].concat();
        assert!(all.as_flattened().iter().all(|x| *x == f32::MAX));
    }
    let points = references(&views, 0);
    let mut unsound = points;
    unsound[4][2] = f32::INFINITY;
    let job = shown(views, 0, &points);
    for (job, [pixel_len, depth_len], expected) in [
        (RenderJob { points: &points[1..], ..job }, [24; 2], (Kind::Length, Argument::Points)),
        (RenderJob { visibility: &[], ..job }, [24; 2], (Kind::Length, Argument::Visibility)),
        (RenderJob { scores: &[0.0], ..job }, [24; 2], (Kind::Length, Argument::Scores)),
        (RenderJob { view: 3, ..job }, [24; 2], (Kind::OutOfRange, Argument::Scores)),
        (RenderJob { width: 0, ..job }, [24; 2], (Kind::Length, Argument::Pixels)),
        (job, [25; 2], (Kind::Length, Argument::Pixels)),
        (job, [24, 23], (Kind::Length, Argument::Depths)),
        (RenderJob { points: &unsound, ..job }, [24; 2], (Kind::NonFinite, Argument::Points)),
    ] {
        let mut pixels = vec![[9; 4]; pixel_len];
        let order = Order::Depth(&mut vec![f32::MAX; depth_len]);
        let found = job.run(order, &mut pixels).unwrap_err();
        assert_eq!((found.kind, found.argument), expected);
        assert!(pixels.iter().all(|pixel| *pixel == [9; 4]));
    }
    let found = job.run(Order::Painter(&mut [0; 5]), &mut [[9; 4]; 24]).unwrap_err();
    assert_eq!(found, error(Kind::Length, Argument::Scratch, 0, [6, 5]));
    assert_eq!(job.run(Order::Painter(&mut [0; 6]), &mut []).unwrap().element_len, 6);
}

#[test]
fn another_objects_map_is_refused() {
    let small = KernelContent::plain(sinew_runtime::kernel::Kernel::Linear, [2, 1, 1]);
    let mut pieces = Pieces::kernels(&[KernelContent::map("walk", 51), small]);
    pieces.add_views(&ViewsContent::sample(vec![0], false));
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let views = model.views().unwrap();
    let map = model.kernel_named("plain").unwrap();
    let Written { mut points, mut visibility, mut scores } = NOTHING;
    let out = Frame { points: &mut points, visibility: &mut visibility, scores: &mut scores };
    let job = FrameJob { views, map, parameters: &[0.0; 2], last: None, margin: 0.0 };
    let found = job.run(&mut [0.0; 256], out).unwrap_err();
    assert_eq!((found.kind, found.argument), (Kind::Length, Argument::Outputs));
}
