//! Objects of key views: frames against the formulas in f64, and pictures against their textures.

use models::{KernelContent, LayerContent, Pieces, Rng, TextureContent, ViewContent, ViewsContent};
use sinew_runtime::views::{Drawn, Found, Layer, NOTHING, RenderScratch};
use sinew_runtime::{
    Argument, CallError, CallErrorKind as Kind, Frame, FrameJob, Model, RenderJob, Views,
};

/// A frame of the sample.
#[derive(Clone, Debug, PartialEq)]
struct Written {
    points: [[f32; 3]; 9],
    visibility: [f32; 9],
    scores: [f32; 3],
    layers: [[f32; 2]; 2],
}

const UNWRITTEN: Written = Written {
    points: [[f32::MAX; 3]; 9],
    visibility: [f32::MAX; 9],
    scores: [f32::MAX; 3],
    layers: [[f32::MAX; 2]; 2],
};

fn file(content: &ViewsContent, map: &KernelContent) -> Model<Vec<u8>> {
    let mut pieces = Pieces::kernels(std::slice::from_ref(map));
    pieces.add_views(content);
    Model::from_bytes(pieces.bytes()).unwrap()
}

fn sample(is_transferred: bool) -> Model<Vec<u8>> {
    file(&ViewsContent::sample(vec![0], is_transferred), &KernelContent::map("walk", 51))
}

fn frame(model: &Model<Vec<u8>>, parameters: &[f32]) -> (Result<Found, CallError>, Written) {
    let views = model.views().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    let mut out = UNWRITTEN;
    let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
    let Written { points, visibility, scores, layers } = &mut out;
    let found = FrameJob { views, map, parameters }
        .run(&mut scratch, Frame { points, visibility, scores, layers });
    (found, out)
}

/// What the map itself gives.
fn outputs(model: &Model<Vec<u8>>, parameters: &[f32]) -> Vec<f32> {
    let map = model.kernel().unwrap();
    let mut out = vec![0.0; map.result_len()];
    map.evaluate(parameters, &mut vec![0.0; map.counts().scratch_len()], &mut out).unwrap();
    out
}

/// Shares of up to eight key views that fit alike, by FORMAT.md.
fn shares(scores: &[f64]) -> Vec<f64> {
    let highest = scores.iter().copied().fold(f64::MIN, f64::max);
    let count = |score: &f64| score.max(0.0) + 1e-3 / (1.0 + highest - score);
    let counts: Vec<f64> = scores.iter().map(count).collect();
    let least = 0.2 * counts.iter().copied().fold(0.0, f64::max);
    let left: Vec<f64> = counts.iter().map(|count| (count - least).max(0.0)).collect();
    let whole: f64 = left.iter().sum();
    left.iter().map(|left| left / whole).collect()
}

#[test]
fn a_frame_is_what_its_map_gives() {
    let model = sample(false);
    let mut is_kept = false;
    for parameters in [[0.0, 0.0], [0.75, -0.5], [-1.0, 1.25], [3.0, 0.0], [-6.0, 0.0]] {
        let (found, out) = frame(&model, &parameters);
        let expected = outputs(&model, &parameters);
        let all = [out.points.as_flattened(), &out.visibility, &out.scores].concat();
        assert_eq!(all, expected[..39]);
        let best = (0..3).max_by(|a, b| out.scores[*a].total_cmp(&out.scores[*b]));
        assert_eq!(Some(found.unwrap().view), best);
        for (layer, [opacity, order]) in out.layers.into_iter().enumerate() {
            let given = expected[39 + layer];
            assert_eq!((opacity, order), (given.clamp(0.0, 1.0), expected[41 + layer]));
            is_kept |= opacity != given;
        }
    }
    assert!(is_kept);
}

#[test]
fn what_is_transferred_moves_as_the_formula_says() {
    let content = ViewsContent::sample(vec![0], true);
    let model = sample(true);
    let mut between = 0;
    for number in 0..60 {
        let parameters = [number as f32 / 20.0 - 1.5, 0.25];
        let plain = outputs(&model, &parameters);
        let scores: Vec<f64> = plain[36..39].iter().map(|x| f64::from(*x)).collect();
        let shares = shares(&scores);
        between += usize::from(shares.iter().filter(|share| **share > 0.01).count() > 1);
        let mean = |at: &dyn Fn(usize) -> f64| -> f64 {
            shares.iter().enumerate().map(|(view, share)| share * at(view)).sum()
        };
        let deformation = |view: usize| content.views[view].deformation.as_ref().unwrap();
        let ratio = mean(&|view| deformation(view).0.into());
        let (_, out) = frame(&model, &parameters);
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
    assert!(between > 10, "{between}");
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
        assert_eq!(frame(&itself, &parameters), frame(&plain, &parameters));
    }
}

#[test]
fn at_the_prototypes_reference_the_instance_has_its_own() {
    let reference = [[3.0, 1.0], [9.0, 2.0], [17.0, 0.0], [2.0, 9.0], [10.0, 8.0], [15.0, 9.0]];
    let reference: Vec<[f32; 2]> =
        reference.into_iter().chain([[2.0, 19.0], [9.0, 17.0], [18.0, 18.0]]).collect();
    let model = sample(false);
    let map = KernelContent::map("walk", 51);
    let (_, plain) = frame(&model, &[0.0, 0.0]);
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
        let (_, out) = frame(&file(&content, &map), &[0.0, 0.0]);
        for (point, own) in out.points.iter().zip(&reference) {
            for axis in 0..2 {
                let expected = own[axis] - mean(&reference, axis) + mean(&prototype, axis);
                assert!((point[axis] - expected).abs() < 2e-5);
            }
        }
    }
}

/// Side of a board and of its textures, in pixels.
const SIDE: usize = 8;
/// Points of a board, two rows of three.
const PLACES: [[f32; 2]; 6] =
    [[0.0, 0.0], [4.0, 0.0], [8.0, 0.0], [0.0, 8.0], [4.0, 8.0], [8.0, 8.0]];
/// An element over all of it, and one over the left half.
const WHOLE: [u16; 4] = [0, 2, 5, 3];
const LEFT: [u16; 4] = [0, 1, 4, 3];

/// A board of layers, each of one element, in three key views; of each layer its texture in each.
fn board(layers: &[([u16; 4], [u32; 3])], textures: Vec<TextureContent>) -> ViewsContent {
    let view = |view: usize| ViewContent {
        name: format!("view {view}"),
        textures: layers.iter().map(|(_, textures)| textures[view]).collect(),
        texels: PLACES.to_vec(),
        references: PLACES.to_vec(),
        visible: vec![true; 6],
        deformation: None,
    };
    let layer = |(element, _): &([u16; 4], [u32; 3])| LayerContent {
        name: "layer".to_owned(),
        elements: vec![*element],
        neighbours: Vec::new(),
        clip: NOTHING,
        flags: 0,
    };
    let mut out = ViewsContent {
        layers: layers.iter().map(layer).collect(),
        textures: textures.clone(),
        ..ViewsContent::plain(Vec::new(), (0..3).map(view).collect(), textures[0].clone())
    };
    out.meet();
    out
}

/// Textures of random texels, of any alpha.
fn noise(len: usize) -> Vec<TextureContent> {
    let mut rng = Rng(7);
    let mut byte = || (rng.next_u64() >> 56) as u8;
    let side = SIDE as u32;
    let mut texels = || (0..SIDE * SIDE).map(|_| [byte(), byte(), byte(), byte()]).collect();
    (0..len).map(|_| TextureContent { width: side, height: side, texels: texels() }).collect()
}

/// Textures of one opaque colour.
fn plain(colours: &[[u8; 3]]) -> Vec<TextureContent> {
    let texture = |[r, g, b]: &[u8; 3]| TextureContent {
        width: 1,
        height: 1,
        texels: vec![[*r, *g, *b, 255]],
    };
    colours.iter().map(texture).collect()
}

/// A file of a board, with a map that gives as many numbers.
fn loaded(content: &ViewsContent) -> Model<Vec<u8>> {
    let mut map = KernelContent::map("walk", 51);
    let numbers = content.point_len + content.views.len() + 2 * content.layers.len();
    map.outputs.drain(content.point_len..9);
    map.outputs.truncate(content.point_len + numbers);
    map.coefficients.truncate(3 * content.point_len + numbers);
    file(content, &map)
}

/// What a board is asked for.
#[derive(Clone)]
struct Asked {
    points: [[f32; 3]; 6],
    visibility: [f32; 6],
    scores: [f32; 3],
    layers: Vec<[f32; 2]>,
}

impl Asked {
    fn new(scores: [f32; 3], layers: &[[f32; 2]]) -> Self {
        let points = PLACES.map(|[x, y]| [x, y, 0.0]);
        Self { points, visibility: [1.0; 6], scores, layers: layers.to_vec() }
    }

    fn job<'a>(&'a self, views: Views<'a>) -> RenderJob<'a> {
        let Self { points, visibility, scores, layers } = self;
        RenderJob { views, points, visibility, scores, layers, width: SIDE }
    }

    fn painted(&self, model: &Model<Vec<u8>>) -> (Drawn, Vec<[u8; 4]>) {
        let mut pixels = vec![[0; 4]; SIDE * SIDE];
        let views = model.views().unwrap();
        let drawn = run(&self.job(views), [6, views.order_len(), 64, 64, 64], &mut pixels);
        (drawn.unwrap(), pixels)
    }
}

/// Runs a job with scratch of so many vertices, numbers, depths, pixels and clips.
fn run(job: &RenderJob<'_>, lens: [usize; 5], out: &mut [[u8; 4]]) -> Result<Drawn, CallError> {
    let [vertices, order, depths, group, clips] = lens;
    let scratch = RenderScratch {
        vertices: &mut vec![[f32::NAN; 3]; vertices],
        order: &mut vec![u16::MAX; order],
        depths: &mut vec![f32::NAN; depths],
        group: &mut vec![[9; 4]; group],
        clips: &mut vec![9; clips],
    };
    job.run(scratch, out)
}

/// A texel times its alpha.
fn texel(texture: &TextureContent, at: usize) -> [f64; 4] {
    let [r, g, b, a] = texture.texels[at].map(f64::from);
    [r * a / 255.0, g * a / 255.0, b * a / 255.0, a]
}

fn assert_mixed(pixels: &[[u8; 4]], textures: &[TextureContent], shares: &[f64]) {
    for (at, pixel) in pixels.iter().enumerate() {
        for (channel, found) in pixel.iter().enumerate() {
            let own =
                textures.iter().zip(shares).map(|(own, share)| share * texel(own, at)[channel]);
            let expected: f64 = own.sum();
            assert!((f64::from(*found) - expected).abs() <= 1.0, "{at}: {found} {expected}");
        }
    }
}

#[test]
fn a_key_view_is_its_texture_and_between_them_all_count() {
    let textures = noise(3);
    let model = loaded(&board(&[(WHOLE, [0, 1, 2])], textures.clone()));
    for scores in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.5, 0.0, 1.0]] {
        let (drawn, pixels) = Asked::new(scores, &[[1.0, 0.0]]).painted(&model);
        assert_eq!(drawn, Drawn { element_len: 1, flipped_len: 0 });
        assert_mixed(&pixels, &textures, &scores.map(|score| f64::from(score.max(0.0))));
    }
    for scores in [[0.6, 0.4, 0.0], [0.25, 0.5, 0.25], [0.3, 0.0, 0.7], [0.4, 0.35, 0.3]] {
        let (_, pixels) = Asked::new(scores, &[[1.0, 0.0]]).painted(&model);
        let shares = shares(&scores.map(f64::from));
        assert!(shares.iter().all(|share| *share < 0.9));
        assert_mixed(&pixels, &textures, &shares);
    }
}

#[test]
fn pictures_are_continuous() {
    let mut content = board(&[(WHOLE, [0, 1, 2])], noise(3));
    // One view hides a point that comes and goes on the way.
    content.views[1].visible[0] = false;
    let model = loaded(&content);
    let changes = |steps: usize| {
        let (mut before, mut changes) = (None::<Vec<[u8; 4]>>, Vec::new());
        for step in 0..=steps {
            let x = 2.0 * step as f32 / steps as f32;
            let scores = [0.0, 1.0, 2.0].map(|view| 1.0 - (x - view).abs());
            let mut asked = Asked::new(scores, &[[1.0, 0.0]]);
            asked.visibility[0] = 0.5 + 0.5 * (3.0 * x).cos();
            let (_, pixels) = asked.painted(&model);
            if let Some(before) = before.replace(pixels.clone()) {
                let apart = before.as_flattened().iter().zip(pixels.as_flattened());
                changes
                    .push(apart.map(|(a, b): (&u8, &u8)| u32::from(a.abs_diff(*b))).sum::<u32>());
            }
        }
        // Of steps at which it changes at all.
        changes.retain(|change| *change > 0);
        changes.sort_unstable();
        (changes[changes.len() / 2], changes[changes.len() - 1])
    };
    let ((median, most), (_, fine)) = (changes(600), changes(4800));
    assert!(most < 8 * median && fine < most / 4, "{most} {median} {fine}");
}

#[test]
fn what_a_view_hides_has_its_colours_from_others() {
    let textures = noise(3);
    let mut content = board(&[(WHOLE, [0, 1, 2])], textures.clone());
    content.views[0].visible[5] = false;
    let model = loaded(&content);
    // Point 5 is to be seen: not view 0, but the next one. It is hidden: view 0 alone shows the element so.
    for (visibility, expected) in [(1.0, [0.0, 1.0, 0.0]), (0.0, [1.0, 0.0, 0.0])] {
        let mut asked = Asked::new([0.7, 0.2, 0.0], &[[1.0, 0.0]]);
        asked.visibility[5] = visibility;
        let (drawn, pixels) = asked.painted(&model);
        assert_eq!(drawn.element_len, 1);
        assert_mixed(&pixels, &textures, &expected);
    }
}

#[test]
fn layers_come_in_their_order() {
    let textures = plain(&[[200, 0, 0], [0, 100, 0]]);
    let model = loaded(&board(&[(WHOLE, [0; 3]), (WHOLE, [1; 3])], textures));
    for (orders, expected) in [([0.0, 1.0], 1), ([1.0, 0.0], 0), ([2.0, 2.0], 1), ([-1.0, -2.0], 0)]
    {
        let asked = Asked::new([1.0, 0.0, 0.0], &orders.map(|order| [1.0, order]));
        let (drawn, pixels) = asked.painted(&model);
        assert_eq!(drawn.element_len, 2);
        assert_eq!(pixels, [[[200, 0, 0, 255], [0, 100, 0, 255]][expected]; SIDE * SIDE]);
    }
}

#[test]
fn layers_are_as_opaque_as_they_are_asked_to_be() {
    let model = loaded(&board(&[(WHOLE, [0; 3])], plain(&[[200, 100, 0]])));
    for (opacity, expected) in [(0.5, [100, 50, 0, 128]), (0.2, [40, 20, 0, 51])] {
        let (_, pixels) = Asked::new([1.0, 0.0, 0.0], &[[opacity, 0.0]]).painted(&model);
        assert_eq!(pixels, [expected; SIDE * SIDE]);
    }
    let (drawn, pixels) = Asked::new([1.0, 0.0, 0.0], &[[0.0, 0.0]]).painted(&model);
    assert_eq!((drawn.element_len, pixels), (0, vec![[0; 4]; SIDE * SIDE]));
}

#[test]
fn a_group_is_blended_once_where_it_lies_on_itself() {
    let mut content = board(&[(WHOLE, [0; 3])], plain(&[[200, 100, 0]]));
    let twice = content.layers[0].elements.clone();
    content.layers[0].elements.extend(twice);
    content.meet();
    let asked = Asked::new([1.0, 0.0, 0.0], &[[0.5, 0.0]]);
    for (flags, expected) in [(Layer::GROUP, [100, 50, 0, 128]), (0, [150, 75, 0, 192])] {
        content.layers[0].flags = flags;
        let (_, pixels) = asked.painted(&loaded(&content));
        assert_eq!(pixels, [expected; SIDE * SIDE], "{flags}");
    }
    // Likewise where its texture is translucent.
    content.textures[0].texels[0][3] = 128;
    let asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]]);
    for (flags, expected) in [(Layer::GROUP, [100, 50, 0, 128]), (0, [150, 75, 0, 192])] {
        content.layers[0].flags = flags;
        let (_, pixels) = asked.painted(&loaded(&content));
        assert_eq!(pixels, [expected; SIDE * SIDE], "{flags}");
    }
}

#[test]
fn elements_of_one_sided_layers_are_drawn_one_way_round() {
    let mut content = board(&[(WHOLE, [0; 3])], plain(&[[200, 100, 0]]));
    let element_len = content.layers[0].elements.len();
    let mut asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]]);
    for (flags, is_mirrored, expected) in [
        (0, false, element_len),
        (0, true, element_len),
        (Layer::ONE_SIDED, false, element_len),
        (Layer::ONE_SIDED, true, 0),
    ] {
        content.layers[0].flags = flags;
        asked.points = PLACES.map(|[x, y]| [if is_mirrored { SIDE as f32 - x } else { x }, y, 0.0]);
        let (drawn, pixels) = asked.painted(&loaded(&content));
        assert_eq!(drawn.element_len, expected, "{flags} {is_mirrored}");
        assert_eq!(pixels.iter().any(|pixel| pixel[3] > 0), expected > 0);
    }
}

#[test]
fn a_layer_shows_itself_where_its_clips_are_opaque() {
    let colours = [[200, 0, 0], [0, 200, 0], [0, 0, 200]];
    let layers = [(LEFT, [0; 3]), (WHOLE, [1; 3]), (WHOLE, [2; 3])];
    let mut content = board(&layers, plain(&colours));
    // The second by the first, the third by both.
    (content.layers[1].clip, content.layers[2].clip) = (0, 1);
    let model = loaded(&content);
    for opacities in [[1.0, 1.0, 1.0], [0.5, 0.75, 1.0], [1.0, 0.25, 0.5], [0.0, 1.0, 1.0]] {
        let asked = Asked::new([1.0, 0.0, 0.0], &opacities.map(|opacity| [opacity, 0.0]));
        let (_, pixels) = asked.painted(&model);
        let [a, b, c] = opacities.map(f64::from);
        let mut expected = [0.0; 4];
        for (colour, alpha) in colours.iter().zip([a, b * a, c * b * a]) {
            let [red, green, blue] = colour.map(f64::from);
            for (below, own) in expected.iter_mut().zip([red, green, blue, 255.0]) {
                *below = alpha * own + (1.0 - alpha) * *below;
            }
        }
        for (at, pixel) in pixels.iter().enumerate() {
            // The border of the left half is on one of pixels.
            let expected = if at % SIDE < 4 { expected } else { [0.0; 4] };
            let apart = pixel.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs());
            assert!(apart.fold(0.0, f64::max) <= 2.0, "{at}: {pixel:?} {expected:?}");
        }
    }
}

#[test]
fn with_depth_the_near_hides_the_far() {
    let mut content = board(&[(WHOLE, [0; 3])], noise(1));
    content.textures[0].texels.iter_mut().for_each(|texel| texel[3] = 255);
    // One over the other, turned by the points of either.
    content.layers[0].elements = vec![[0, 1, 4, 3], [1, 2, 5, 4]];
    content.layers[0].flags = Layer::DEPTH;
    content.meet();
    let model = loaded(&content);
    let mut asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]]);
    // The right half folds over the left one.
    (asked.points[2], asked.points[5]) = ([0.0, 0.0, 1.0], [0.0, 8.0, 1.0]);
    let (far, near) = {
        let far = asked.painted(&model);
        (asked.points[2][2], asked.points[5][2]) = (-1.0, -1.0);
        (far, asked.painted(&model))
    };
    assert_eq!((far.0, near.0), (near.0, Drawn { element_len: 2, flipped_len: 1 }));
    // What is folded shows the right half of the texture, mirrored.
    let own = texel(&content.textures[0], 3 * SIDE + 1);
    let other = texel(&content.textures[0], 3 * SIDE + 6);
    for (pixels, expected) in [(&far.1, own), (&near.1, other)] {
        let apart = pixels[3 * SIDE + 1].iter().zip(expected);
        assert!(apart.map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max) <= 1.0);
    }
}

#[test]
fn refused_calls_have_written_nothing() {
    let model = sample(true);
    let views = model.views().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    for (parameters, expected) in [
        (vec![0.0; 3], (Kind::Length, Argument::Query)),
        (vec![0.0, f32::NAN], (Kind::NonFinite, Argument::Query)),
        (vec![1e38; 2], (Kind::NonFinite, Argument::Points)),
        (vec![3e38; 2], (Kind::NonFinite, Argument::Outputs)),
    ] {
        let (found, out) = frame(&model, &parameters);
        let error = found.unwrap_err();
        assert_eq!(((error.kind, error.argument), out), (expected, UNWRITTEN));
    }
    let error = |kind, argument, [expected, found]: [usize; 2]| CallError {
        kind,
        argument,
        index: 0,
        expected,
        found,
    };
    let least = views.counts().frame_scratch_len(&map.counts());
    for (lens, expected) in [
        ([8, 9, 3, 2, least], error(Kind::Length, Argument::Points, [9, 8])),
        ([9, 10, 3, 2, least], error(Kind::Length, Argument::Visibility, [9, 10])),
        ([9, 9, 2, 2, least], error(Kind::Length, Argument::Scores, [3, 2])),
        ([9, 9, 3, 1, least], error(Kind::Length, Argument::Layers, [2, 1])),
        ([9, 9, 3, 2, least - 1], error(Kind::TooShort, Argument::Scratch, [least, least - 1])),
    ] {
        let (mut points, mut layers) = (vec![[f32::MAX; 3]; lens[0]], vec![[f32::MAX; 2]; lens[3]]);
        let [mut visibility, mut scores] = [lens[1], lens[2]].map(|len| vec![f32::MAX; len]);
        let frame = Frame {
            points: &mut points,
            visibility: &mut visibility,
            scores: &mut scores,
            layers: &mut layers,
        };
        let job = FrameJob { views, map, parameters: &[0.0; 2] };
        assert_eq!(job.run(&mut vec![0.0; lens[4]], frame), Err(expected));
        let all = [points.as_flattened(), &visibility, &scores, layers.as_flattened()].concat();
        assert!(all.iter().all(|x| *x == f32::MAX));
    }
    let mut content = board(&[(WHOLE, [0; 3]), (LEFT, [0; 3])], noise(1));
    content.layers[1].clip = 0;
    content.layers[0].flags = Layer::DEPTH;
    let model = loaded(&content);
    let asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]; 2]);
    let job = asked.job(model.views().unwrap());
    let mut unsound = asked.points;
    unsound[4][2] = f32::INFINITY;
    // Numbers that are sorted: of two elements and two layers.
    let lens = [6, 4, 16, 16, 16];
    for (job, lens, pixel_len, expected) in [
        (
            RenderJob { points: &asked.points[1..], ..job },
            lens,
            16,
            (Kind::Length, Argument::Points),
        ),
        (RenderJob { visibility: &[], ..job }, lens, 16, (Kind::Length, Argument::Visibility)),
        (RenderJob { scores: &[0.0], ..job }, lens, 16, (Kind::Length, Argument::Scores)),
        (RenderJob { layers: &[], ..job }, lens, 16, (Kind::Length, Argument::Layers)),
        (RenderJob { width: 0, ..job }, lens, 16, (Kind::Length, Argument::Pixels)),
        (job, [6, 4, 17, 17, 17], 17, (Kind::Length, Argument::Pixels)),
        (job, [5, 4, 16, 16, 16], 16, (Kind::Length, Argument::Vertices)),
        (job, [6, 3, 16, 16, 16], 16, (Kind::Length, Argument::Scratch)),
        (job, [6, 4, 15, 16, 16], 16, (Kind::TooShort, Argument::Depths)),
        (job, [6, 4, 16, 15, 16], 16, (Kind::TooShort, Argument::Group)),
        (job, [6, 4, 16, 16, 15], 16, (Kind::TooShort, Argument::Clips)),
        (RenderJob { points: &unsound, ..job }, lens, 16, (Kind::NonFinite, Argument::Points)),
    ] {
        let mut pixels = vec![[9; 4]; pixel_len];
        let found = run(&job, lens, &mut pixels).unwrap_err();
        assert_eq!((found.kind, found.argument), expected);
        assert!(pixels.iter().all(|pixel| *pixel == [9; 4]));
    }
    assert_eq!(run(&job, lens, &mut []).unwrap().element_len, 2);
    assert!(run(&job, lens, &mut [[9; 4]; 16]).is_ok());
}

#[test]
fn another_objects_map_is_refused() {
    let small = KernelContent::plain(sinew_runtime::kernel::Kernel::Linear, [2, 1, 1]);
    let mut pieces = Pieces::kernels(&[KernelContent::map("walk", 51), small]);
    pieces.add_views(&ViewsContent::sample(vec![0], false));
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let views = model.views().unwrap();
    let map = model.kernel_named("plain").unwrap();
    let Written { mut points, mut visibility, mut scores, mut layers } = UNWRITTEN;
    let (points, visibility, scores) = (&mut points, &mut visibility, &mut scores);
    let out = Frame { points, visibility, scores, layers: &mut layers };
    let job = FrameJob { views, map, parameters: &[0.0; 2] };
    let found = job.run(&mut [0.0; 256], out).unwrap_err();
    assert_eq!((found.kind, found.argument), (Kind::Length, Argument::Outputs));
}
