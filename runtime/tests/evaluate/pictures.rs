//! Pictures of key views against their textures.

use super::views::{file, shares};
use models::{KernelContent, LayerContent, Rng, TextureContent, ViewContent, ViewsContent};
use sinew_runtime::views::{Drawn, Layer, NOTHING, RenderScratch};
use sinew_runtime::{Argument, CallError, CallErrorKind as Kind, Model, RenderJob, Views};

/// Side of a board and of its textures, in pixels.
const SIDE: usize = 8;
/// Points of a board, two rows of three.
const PLACES: [[f32; 2]; 6] =
    [[0.0, 0.0], [4.0, 0.0], [8.0, 0.0], [0.0, 8.0], [4.0, 8.0], [8.0, 8.0]];
/// An element over the full board, and an element over the left half.
const WHOLE: [u16; 4] = [0, 2, 5, 3];
const LEFT: [u16; 4] = [0, 1, 4, 3];

/// A board of layers with one element each, in three key views; each layer lists its texture in
/// every view.
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

/// Random texels with any alpha.
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

/// A file of a board, with a map of matching outputs.
fn loaded(content: &ViewsContent) -> Model<Vec<u8>> {
    let mut map = KernelContent::map("walk", 51);
    let numbers = content.point_len + content.views.len() + 2 * content.layers.len();
    map.outputs.drain(content.point_len..9);
    map.outputs.truncate(content.point_len + numbers);
    map.coefficients.truncate(3 * content.point_len + numbers);
    file(content, &map)
}

/// Arguments of a frame of the board.
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
        let views = model.first::<Views>().unwrap();
        let drawn = run(&self.job(views), [6, views.order_len(), 64, 64, 64], &mut pixels);
        (drawn.unwrap(), pixels)
    }
}

/// Runs a job with scratch of these lengths: vertices, order, depths, pixels and clips.
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
    // One view hides a point that appears and disappears on the way.
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
        // Only steps with a change.
        changes.retain(|change| *change > 0);
        changes.sort_unstable();
        (changes[changes.len() / 2], changes[changes.len() - 1])
    };
    let ((median, most), (_, fine)) = (changes(600), changes(4800));
    assert!(most < 8 * median && fine < most / 4, "{most} {median} {fine}");
}

#[test]
fn colours_hidden_in_a_view_come_from_other_views() {
    let textures = noise(3);
    let mut content = board(&[(WHOLE, [0, 1, 2])], textures.clone());
    content.views[0].visible[5] = false;
    let model = loaded(&content);
    // A visible point 5 rules out view 0, and the next view draws the element. A hidden point 5
    // leaves only view 0, which shows the element with the point hidden.
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
    // The layer's translucent texture gives the same result.
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
    // The first layer clips the second, and both clip the third.
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
            // The border of the left half is on a border of pixels.
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
    // One above the other; the points of each element can flip it.
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
    // The folded part shows the right half of the texture, mirrored.
    let own = texel(&content.textures[0], 3 * SIDE + 1);
    let other = texel(&content.textures[0], 3 * SIDE + 6);
    for (pixels, expected) in [(&far.1, own), (&near.1, other)] {
        let apart = pixels[3 * SIDE + 1].iter().zip(expected);
        assert!(apart.map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max) <= 1.0);
    }
}

#[test]
fn a_fold_is_soft_in_a_layer_with_depth_unless_it_is_thin() {
    let alpha = |flags: u32, folded: f32| {
        let mut content = board(&[(WHOLE, [0; 3])], plain(&[[9; 3]]));
        content.layers[0].elements = vec![[0, 1, 4, 3], [1, 2, 5, 4]];
        content.layers[0].flags = flags;
        content.meet();
        let mut asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]]);
        // The fold lies a quarter of a pixel before a pixel's centre, as does the edge of the right
        // half behind.
        asked.points[1][0] = 4.25;
        asked.points[4][0] = 4.25;
        (asked.points[2], asked.points[5]) = ([folded, 0.0, 1.0], [folded, 8.0, 1.0]);
        asked.painted(&loaded(&content)).1[3 * SIDE + 4][3]
    };
    assert_eq!(alpha(0, 0.0), 0, "without depth");
    // Each covers a quarter of the pixel.
    assert_eq!(alpha(Layer::DEPTH, 0.0), (255.0f64 * (1.0 - 0.75 * 0.75)).round() as u8);
    // The fold is 0.4 pixels wide: its edge is soft, and the edge of the half below is not.
    assert_eq!(alpha(Layer::DEPTH, 3.85), (255.0f64 * 0.25).round() as u8);
}

#[test]
fn refused_pictures_have_written_nothing() {
    let mut content = board(&[(WHOLE, [0; 3]), (LEFT, [0; 3])], noise(1));
    content.layers[1].clip = 0;
    content.layers[0].flags = Layer::DEPTH;
    let model = loaded(&content);
    let asked = Asked::new([1.0, 0.0, 0.0], &[[1.0, 0.0]; 2]);
    let job = asked.job(model.first::<Views>().unwrap());
    let mut unsound = asked.points;
    unsound[4][2] = f32::INFINITY;
    // Length of the order: two elements and two layers.
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
