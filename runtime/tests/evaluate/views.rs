//! Objects of key views: frames against the formulas in f64.

use models::{KernelContent, Pieces, ViewsContent};
use sinew_runtime::views::Found;
use sinew_runtime::{
    Argument, CallError, CallErrorKind as Kind, Frame, FrameJob, KernelMap, Model, Views,
};

/// A frame of the sample, as written.
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

pub(crate) fn file(content: &ViewsContent, map: &KernelContent) -> Model<Vec<u8>> {
    let mut pieces = Pieces::kernels(std::slice::from_ref(map));
    pieces.add_views(content);
    Model::from_bytes(pieces.bytes()).unwrap()
}

fn sample(is_transferred: bool) -> Model<Vec<u8>> {
    file(&ViewsContent::sample(vec![0], is_transferred), &KernelContent::map("walk", 51))
}

fn frame(model: &Model<Vec<u8>>, parameters: &[f32]) -> (Result<Found, CallError>, Written) {
    let views = model.first::<Views>().unwrap();
    let map = model.map_of(&views, 0).unwrap();
    let mut out = UNWRITTEN;
    let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
    let Written { points, visibility, scores, layers } = &mut out;
    let found = FrameJob { views, map, parameters }
        .run(&mut scratch, &mut Frame { points, visibility, scores, layers });
    (found, out)
}

/// The outputs of the map itself.
fn outputs(model: &Model<Vec<u8>>, parameters: &[f32]) -> Vec<f32> {
    let map = model.first::<KernelMap>().unwrap();
    let mut out = vec![0.0; map.result_len()];
    map.evaluate(parameters, &mut vec![0.0; map.counts().scratch_len()], &mut out).unwrap();
    out
}

/// Shares of up to eight equally fitting key views, by FORMAT.md.
pub(crate) fn shares(scores: &[f64]) -> Vec<f64> {
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
fn a_transferred_object_moves_by_the_formula() {
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
fn an_object_transferred_onto_itself_keeps_its_bits() {
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

#[test]
fn refused_frames_have_written_nothing() {
    let model = sample(true);
    let views = model.first::<Views>().unwrap();
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
        let mut frame = Frame {
            points: &mut points,
            visibility: &mut visibility,
            scores: &mut scores,
            layers: &mut layers,
        };
        let job = FrameJob { views, map, parameters: &[0.0; 2] };
        assert_eq!(job.run(&mut vec![0.0; lens[4]], &mut frame), Err(expected));
        let all = [points.as_flattened(), &visibility, &scores, layers.as_flattened()].concat();
        assert!(all.iter().all(|x| *x == f32::MAX));
    }
}

#[test]
fn another_objects_map_is_refused() {
    let small = KernelContent::plain(sinew_runtime::kernel::Kernel::Linear, [2, 1, 1]);
    let mut pieces = Pieces::kernels(&[KernelContent::map("walk", 51), small]);
    pieces.add_views(&ViewsContent::sample(vec![0], false));
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let views = model.first::<Views>().unwrap();
    let map = model.named::<KernelMap>("plain").unwrap();
    let Written { mut points, mut visibility, mut scores, mut layers } = UNWRITTEN;
    let (points, visibility, scores) = (&mut points, &mut visibility, &mut scores);
    let mut out = Frame { points, visibility, scores, layers: &mut layers };
    let job = FrameJob { views, map, parameters: &[0.0; 2] };
    let found = job.run(&mut [0.0; 256], &mut out).unwrap_err();
    assert_eq!((found.kind, found.argument), (Kind::Length, Argument::Outputs));
}
