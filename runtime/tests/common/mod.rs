//! Shared by the tests: expected errors, and evaluation into new arrays.
#![allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::unwrap_used,
    reason = "each test uses a part of it"
)]

use models::{Pieces, Rng, Shape, cells};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::filter::Samples;
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::prior::Anchor;
use sinew_runtime::skin::Output;
use sinew_runtime::views::{CLIPS_MAX, RenderScratch};
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Envelope, FileError, FileErrorKind, Filter, Frame,
    FrameJob, KernelMap, Matrix3x4, Model, Pin, PinJob, Pins, Prior, Record, RenderJob, Skin,
    SkinJob, Views, model_space_pose,
};
use std::cell::Cell;

/// Makes the error of a call; fields that a kind does not use are 0.
pub const fn call_error(kind: CallErrorKind, argument: Argument) -> CallError {
    CallError { kind, argument, index: 0, expected: 0, found: 0 }
}

/// Makes the error for an argument of another length.
pub const fn length_error(argument: Argument, expected: usize, found: usize) -> CallError {
    CallError { expected, found, ..call_error(CallErrorKind::Length, argument) }
}

/// Makes the error for an argument that is too short.
pub const fn short_error(argument: Argument, expected: usize, found: usize) -> CallError {
    CallError { expected, found, ..call_error(CallErrorKind::TooShort, argument) }
}

/// Makes the error for a stage that a predictor lacks.
pub fn stage_error(predictor: Predictor) -> CallError {
    let found = predictor.number().into();
    CallError { found, ..call_error(CallErrorKind::NoStage, Argument::Call) }
}

/// Makes the error of a file as a whole; fields that a kind does not use are 0.
pub const fn file_error(kind: FileErrorKind) -> FileError {
    FileError { kind, part: None, section: None, index: 0, expected: 0, found: 0 }
}

/// Makes the error of a section in the sample's envelope.
pub const fn envelope_error(kind: FileErrorKind, section: SectionKind) -> FileError {
    FileError { part: Some(0), section: Some(section), ..file_error(kind) }
}

/// Makes the error of a section in the sample's skin.
pub const fn skin_error(kind: FileErrorKind, section: SectionKind) -> FileError {
    FileError { part: Some(1), section: Some(section), ..file_error(kind) }
}

/// Step between the tested cases of a loop: 1 tests all. Miri is a thousand times slower.
pub const fn apart(under_miri: usize) -> usize {
    if cfg!(miri) { under_miri } else { 1 }
}

/// Makes the J skinning matrices of a random pose.
pub fn random_pose(envelope: &Envelope<'_>, rng: &mut Rng, turn: f32) -> Vec<Matrix3x4> {
    let local = (0..envelope.joint_len()).map(|_| rng.local(turn)).collect::<Vec<_>>();
    let mut pose = vec![IDENTITY; envelope.joint_len()];
    model_space_pose(envelope, &local, &mut pose).unwrap();
    pose
}

pub const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A pose whose joints stretch.
pub struct Stretched {
    /// J skinning matrices: those of `rigid`, with a linear part R S in place of R where a joint
    /// stretches.
    pub pose: Vec<Matrix3x4>,
    /// The pose without stretch. S is symmetric and positive, so R is the rotation nearest to R S.
    pub rigid: Vec<Matrix3x4>,
    /// C values from -1 to 1.
    pub curves: Vec<f32>,
}

/// Makes a random pose with random curves. Joints that stretched in training are scaled by factors of
/// about 1/2 to 2, and sheared.
pub fn stretched_pose(envelope: &Envelope<'_>, rng: &mut Rng, turn: f32) -> Stretched {
    let rigid = random_pose(envelope, rng, turn);
    let pose = rigid.iter().enumerate().map(|(joint, map)| {
        if envelope.stretch_range(joint) == Some(0.0) {
            return *map;
        }
        let [a, b, c, d, e, f] = [(); 6].map(|()| rng.unit());
        let [x, y, z] = [a, b, c].map(|x| 2f32.powf(x));
        let [d, e, f] = [d, e, f].map(|x| 0.15 * x);
        let stretch = [[x, d, e], [d, y, f], [e, f, z]];
        map.map(|[p, q, r, shift]| {
            let entry = |c: usize| p * stretch[0][c] + q * stretch[1][c] + r * stretch[2][c];
            [entry(0), entry(1), entry(2), shift]
        })
    });
    let pose = pose.collect();
    Stretched { pose, rigid, curves: (0..envelope.curve_len()).map(|_| rng.unit()).collect() }
}

/// Computes the palette in scratch of exactly the stated length; the curves are 0.
pub fn palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    confident_palette(envelope, pose).0
}

/// Computes the palette and the pose's confidence; the curves are 0.
pub fn confident_palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
    palette_with(envelope, pose, &vec![0.0; envelope.curve_len()])
}

/// Computes the palette of a pose with curves, and its confidence.
pub fn palette_with(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
) -> (Vec<Matrix3x4>, f32) {
    let mut scratch = vec![f32::NAN; envelope.scratch_len()];
    let mut out = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    let confidence = envelope.palette(pose, curves, &mut scratch, &mut out).unwrap();
    (out, confidence)
}

/// Returns the largest difference; panics on NaN, on nothing to compare, on unequal lengths.
pub fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len(), "lengths");
    assert!(!a.is_empty(), "nothing to compare");
    assert!(a.iter().chain(b).all(|x| x.is_finite()), "not finite");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Returns the bits of floats, which distinguish -0 from 0.
pub fn bits(floats: &[f32]) -> Vec<u32> {
    floats.iter().map(|x| x.to_bits()).collect()
}

pub fn with_envelope(shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    with_predictor(Predictor::Rotational, shape, test);
}

pub fn with_predictor(predictor: Predictor, shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    with_model(predictor, shape, |envelope, _| test(envelope));
}

/// Runs a test on the sample's envelope and its skin.
pub fn with_skin(shape: Shape, test: impl FnOnce(Envelope<'_>, Skin<'_>)) {
    with_model(Predictor::Rotational, shape, test);
}

pub fn with_model(predictor: Predictor, shape: Shape, test: impl FnOnce(Envelope<'_>, Skin<'_>)) {
    let model = Model::from_bytes(Pieces::sample(predictor, shape).bytes()).unwrap();
    test(model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
}

/// Lends floats to an attribute.
pub const fn output(floats: &[Cell<f32>], stride: usize) -> Option<Output<'_>> {
    Some(Output::shared(floats, stride))
}

/// Runs a job with positions and normals (3 floats each) and tangents (4), each in its own run of
/// the result. Tangents are left out if neither the skin nor the job has any.
pub fn run(job: &SkinJob<'_>) -> Vec<f32> {
    let n = job.range().len();
    let mut out = vec![f32::NAN; 10 * n];
    let lent = cells(&mut out);
    let (positions, normals) = (Output::shared(lent, 3), Output::shared(&lent[3 * n..], 3));
    let both = job.clone().positions(positions).normals(normals);
    let tangents = Output::shared(&lent[6 * n..], 4);
    match both.clone().tangents(tangents).run() {
        Err(error) if error.kind == CallErrorKind::NoAttribute => {
            both.run().unwrap();
            out.truncate(6 * n);
        }
        done => done.unwrap(),
    }
    out
}

/// Skins every vertex; see [`run`].
pub fn skinned(skin: Skin<'_>, palette: &[Matrix3x4]) -> Vec<f32> {
    run(&SkinJob::new(skin, palette))
}

/// Returns the rest mesh, in the layout of [`run`].
pub fn rest(skin: Skin<'_>) -> Vec<f32> {
    let v = 0..skin.vertex_len();
    let positions = v.clone().flat_map(|v| skin.rest_position(v).unwrap());
    let normals = v.clone().flat_map(|v| skin.rest_normal(v).unwrap());
    positions.chain(normals).chain(v.filter_map(|v| skin.rest_tangent(v)).flatten()).collect()
}

/// Evaluates everything in a model. Nothing may panic.
pub fn exercise(bytes: &[u8]) -> Option<()> {
    let model = Model::from_bytes(bytes).ok()?;
    assert!(model.sections().all(|section| section.bytes.len() == section.row.bytes as usize));
    let known = PartKind::ALL.map(PartKind::number);
    let found = model.all::<Envelope>().count()
        + model.all::<Skin>().count()
        + model.all::<KernelMap>().count();
    let found = found + model.all::<Prior>().count() + model.all::<Views>().count();
    let found = found + model.all::<Filter>().count() + model.all::<Record>().count();
    assert_eq!(found, model.parts().filter(|row| known.contains(&row.kind)).count());
    model.all::<Envelope>().for_each(|envelope| exercise_envelope(&envelope));
    model.all::<KernelMap>().for_each(|map| exercise_kernel(&map));
    model.all::<Filter>().for_each(|filter| exercise_filter(&filter));
    for prior in model.all::<Prior>() {
        exercise_prior(&prior, &model.skin_of(&prior).unwrap());
    }
    for views in model.all::<Views>() {
        exercise_views(&model, &views);
    }
    for skin in model.all::<Skin>() {
        let envelope = model.envelope_of(&skin);
        assert_eq!(envelope.is_some(), skin.envelope_part().is_some());
        let len = envelope.map_or(0, |envelope| envelope.palette_len());
        assert_eq!(skin.palette_len(), len);
        exercise_skin(skin, &vec![IDENTITY; len]);
        if let Some(envelope) = envelope {
            let pose = vec![IDENTITY; envelope.joint_len()];
            exercise_skin(skin, &palette(&envelope, &pose));
        }
    }
    Some(())
}

fn exercise_prior(prior: &Prior<'_>, skin: &Skin<'_>) {
    let n = prior.shape_len();
    assert!((0..n).all(|s| prior.mean(s).is_some() && prior.weight_bounds(s).is_some()));
    assert!((0..n).all(|s| prior.factor_entry(s, s).is_some_and(|x| x > 0.0)));
    let palette = vec![IDENTITY; skin.palette_len()];
    let mut pins = Pins::<2>::new();
    for vertex in (0..skin.vertex_len() as u32).take(2) {
        pins.add(Pin::new(vertex, [0.5, 1.0, -0.25])).unwrap();
    }
    let len = prior.counts().pin_scratch_len(pins.list().scalar_len());
    let mut weights = vec![0.25; n];
    let job = PinJob {
        palette: &palette,
        anchor: Anchor::Mean,
        cancels: true,
        symmetry: 1.0,
        ..PinJob::new(*prior, *skin, pins.list())
    };
    let done = job.run(&mut vec![f64::NAN; len], &mut weights);
    assert!(weights.iter().all(|w| w.is_finite()));
    assert!(done.is_ok() || weights.iter().all(|w| *w == 0.25));
}

fn exercise_views(model: &Model<&[u8]>, views: &Views<'_>) {
    let (k, v, n, l) = (views.point_len(), views.vertex_len(), views.view_len(), views.layer_len());
    let texture = |view: usize, layer: usize| {
        views.view_texture(view, layer).is_none_or(|texture| views.texture(texture).is_some())
    };
    assert!((0..n).all(|view| views.view_name(view).is_some()));
    assert!((0..n).all(|view| (0..l).all(|layer| texture(view, layer))));
    for layer in 0..l {
        assert!(views.layer_name(layer).is_some() && views.clips(layer).count() <= CLIPS_MAX);
        let layer = views.layer(layer).unwrap();
        assert!(layer.first <= layer.end && layer.end <= views.element_len());
    }
    for vertex in 0..v {
        assert!(views.vertex(vertex).unwrap().weights().all(|(point, _)| point < k));
    }
    for element in 0..views.element_len() {
        assert!(views.element(element).unwrap().vertices().iter().all(|vertex| *vertex < v));
        let neighbours = views.neighbours(element).unwrap();
        assert!(neighbours.into_iter().flatten().all(|other| other < views.element_len()));
    }
    let (mut points, mut visibility) = (vec![[f32::NAN; 3]; k], vec![f32::NAN; k]);
    let (mut scores, mut layers) = (vec![f32::NAN; n], vec![[f32::NAN; 2]; l]);
    for map in 0..views.counts().map_len as usize {
        let map = model.map_of(views, map).unwrap();
        let parameters = vec![0.5; map.query_len()];
        let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
        let (points, visibility) = (points.as_mut_slice(), visibility.as_mut_slice());
        let (scores, layers) = (scores.as_mut_slice(), layers.as_mut_slice());
        let mut out = Frame { points, visibility, scores, layers };
        let job = FrameJob { views: *views, map, parameters: &parameters };
        let Ok(_) = job.run(&mut scratch, &mut out) else { continue };
        assert!(points.as_flattened().iter().all(|x| x.is_finite()));
        let job = RenderJob { views: *views, points, visibility, scores, layers, width: 16 };
        let mut pixels = [[0; 4]; 16 * 12];
        let scratch = RenderScratch {
            vertices: &mut vec![[f32::NAN; 3]; v],
            order: &mut vec![u16::MAX; views.order_len()],
            depths: &mut [f32::NAN; 16 * 12],
            group: &mut [[9; 4]; 16 * 12],
            clips: &mut [9; 16 * 12],
        };
        assert!(job.run(scratch, &mut pixels).is_ok());
    }
}

fn exercise_kernel(map: &KernelMap<'_>) {
    let counts = map.counts();
    assert!((0..counts.input_len as usize).all(|i| map.input_name(i).is_some()));
    assert!((0..counts.output_len as usize).all(|o| map.output_name(o).is_some()));
    assert_eq!(map.inputs().count(), counts.input_len as usize);
    assert_eq!(map.outputs().count(), counts.output_len as usize);
    let query = vec![0.5; map.query_len()];
    let mut out = vec![f32::NAN; map.result_len()];
    let done = map.evaluate(&query, &mut vec![f32::NAN; counts.scratch_len()], &mut out);
    assert!(out.iter().all(|x| x.is_finite() == done.is_ok()));
    assert!(done.is_err() || done.is_ok_and(|confidence| (0.0..=1.0).contains(&confidence)));
}

fn exercise_filter(filter: &Filter<'_>) {
    let (n, factor) = (filter.tap_len(), filter.factor());
    assert!(filter.tap(n - 1, factor - 1, n - 1).is_some() && filter.tap(n, 0, 0).is_none());
    let shape = Samples::of_signal(n + 1);
    let mut fine = vec![f32::NAN; (n + 1) * factor];
    assert!(filter.apply(shape, &vec![1.0; n + 1], &mut fine).is_ok());
    assert!(fine.iter().all(|x| x.is_finite()));
}

fn exercise_envelope(envelope: &Envelope<'_>) {
    let (j, c) = (envelope.joint_len(), envelope.curve_len());
    assert!(
        (0..j).all(|j| envelope.joint_name(j).is_some() && envelope.stretch_range(j).is_some())
    );
    assert!((0..c).all(|c| envelope.curve_name(c).is_some() && envelope.curve_range(c).is_some()));
    let reconstructs = envelope.predictor().reconstructs();
    assert!((0..envelope.proxy_len()).all(|l| envelope.key(l).is_some() == reconstructs));
    assert_eq!(envelope.groups().count(), envelope.group_len());
    let (transforms, _) = confident_palette(envelope, &vec![IDENTITY; envelope.joint_len()]);
    assert!(transforms.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
    // A pose with rotations gives the kernel maps work.
    let local = vec![Rng(1).local(0.2); envelope.joint_len()];
    let mut pose = vec![IDENTITY; envelope.joint_len()];
    if model_space_pose(envelope, &local, &mut pose).is_ok() && rigid(&pose) {
        let (transforms, confidence) = palette_with(envelope, &pose, &vec![0.5; c]);
        assert!(transforms.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
        assert!((0.0..=1.0).contains(&confidence));
    }
}

fn exercise_skin(skin: Skin<'_>, palette: &[Matrix3x4]) {
    assert!(skinned(skin, palette).iter().all(|x| x.is_finite()));
    assert!(skin.bounds(palette, 0.0).is_ok());
    let v = 0..skin.vertex_len();
    assert!(v.clone().all(|v| skin.influences(v).all(|i| i.0 < palette.len())));
    assert!(v.clone().all(|v| skin.influences(v).len() == skin.influence_len()));
    assert_eq!(skin.ranges().count(), skin.counts().range_len as usize);
    assert!(skin.ranges().all(|(_, range)| range.start <= range.end && range.end <= v.end));
}

/// Whether a pose's matrices are rotations. With the bind matrices of a damaged file they are not.
fn rigid(pose: &[Matrix3x4]) -> bool {
    let unit = |m: &Matrix3x4| m.map(|[x, y, z, _]| (x * x + y * y + z * z - 1.0).abs() < 1e-3);
    pose.iter().all(|m| unit(m) == [true; 3] && m.iter().all(|row| row[3].abs() < 1e3))
}
