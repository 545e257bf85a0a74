//! Evaluates every part of an accepted file and checks the promises of the runtime.

use crate::parts::{
    evaluate_filter, evaluate_kernel, evaluate_prior, read_filter, read_kernel, read_prior,
};
use crate::poses::{curves, pose};
use crate::views::{evaluate_views, read_views};
use models::{Rest, cells};
use sinew_runtime::envelope::{Key, Predictor, ScratchLayout, Trs};
use sinew_runtime::skin::{Bounds, Output};
use sinew_runtime::{
    CallError, Envelope, Filter, KernelMap, Limits, Matrix3x4, Model, Prior, Record, ShapesJob,
    Skin, SkinJob, Views,
};
use std::ops::Range;

/// Reads every accessor of a model.
///
/// # Panics
/// If an accessor lacks a value that a loaded model must have, or if the model asks for more work
/// or memory than its file's length allows. Every loop of loading and evaluating runs over these
/// counts or over bytes of the file.
pub fn read<B: AsRef<[u8]>>(model: &Model<B>) {
    assert!(model.sections().all(|section| section.bytes.len() == section.row.bytes as usize));
    let followed: Vec<_> = model.all::<Skin>().filter_map(|skin| skin.envelope_part()).collect();
    for envelope in model.all::<Envelope>() {
        read_envelope(&envelope, model.as_bytes(), followed.contains(&envelope.part()));
    }
    for skin in model.all::<Skin>() {
        let envelope = model.envelope_of(&skin);
        assert_eq!(envelope.map(|envelope| envelope.part()), skin.envelope_part());
        let palette_len = envelope.map_or(0, |envelope| envelope.palette_len());
        assert_eq!(skin.palette_len(), palette_len);
        read_skin(&skin, model.as_bytes());
    }
    model.all::<KernelMap>().for_each(|map| read_kernel(&map, model.as_bytes()));
    for prior in model.all::<Prior>() {
        let skin = model.skin_of(&prior).map(|skin| skin.shape_len());
        assert_eq!(skin, Some(prior.shape_len()));
        read_prior(&prior, model.as_bytes());
    }
    model.all::<Views>().for_each(|views| read_views(model, &views));
    model.all::<Filter>().for_each(|filter| read_filter(&filter, model.as_bytes()));
    for record in model.all::<Record>() {
        let record = record.layout().open::<Record>(model.as_bytes()).expect("its own file");
        assert_eq!(record.frame_marks().len(), record.counts().frame_len as usize);
        for vertex in 0..record.counts().vertex_len as usize {
            let joints = record.lbs_influences(vertex).into_iter().flatten();
            joints.for_each(|(joint, _)| assert!(joint < record.counts().joint_len as usize));
        }
    }
    let part = |envelope: Envelope<'_>| envelope.part();
    assert_eq!(model.first::<Envelope>().map(part), model.all::<Envelope>().next().map(part));
}

const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn read_envelope(envelope: &Envelope<'_>, file: &[u8], is_followed: bool) {
    let (joint_len, palette_len) = (envelope.joint_len(), envelope.palette_len());
    assert_eq!(envelope.evaluation_order().count(), joint_len);
    for joint in 0..joint_len {
        assert!(envelope.joint_name(joint).is_some() && envelope.inverse_bind(joint).is_some());
        assert!(envelope.parent(joint).is_none_or(|parent| parent < joint_len));
        let range = envelope.stretch_range(joint).expect("a joint has a range");
        assert!(range == 0.0 || range > 0.0 && envelope.stretches());
    }
    for helper in 0..envelope.proxy_len() {
        assert!(envelope.helper_centre(helper).is_some());
        let [xx, _, _, yy, _, zz] = envelope.helper_spread(helper).expect("a helper has a spread");
        assert!([xx, yy, zz].iter().all(|own| (0.01..=2.0).contains(own)));
    }
    for curve in 0..envelope.curve_len() {
        assert!(envelope.curve_name(curve).is_some());
        assert!(envelope.curve_range(curve).is_some_and(|[least, most]| least <= most));
    }
    let at_once = ScratchLayout::at_once(envelope).len;
    let mut costs = vec![58 * joint_len, 12 * envelope.curve_len()];
    if is_followed || envelope.predictor() != Predictor::Kernel {
        costs.extend([24 * palette_len, envelope.scratch_len()]);
    } else {
        // Helpers of a group without centres take no bytes outside the skin: the limits bound their
        // number.
        let Limits { joints, proxies, curves, .. } = Limits::DEFAULT;
        let most = (joints + proxies + curves) as usize;
        assert!(palette_len <= most && envelope.scratch_len() <= 32 * most);
    }
    for cost in costs {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    // Every group counts its share again.
    assert!(at_once <= 4 * file.len() * (1 + envelope.group_len()));
    let reconstructs = envelope.predictor().reconstructs();
    let is_right = |key: Key| key.stretch.is_some() == envelope.stretches();
    let is_key = |proxy: usize| envelope.key(proxy).is_some_and(is_right);
    assert!((0..envelope.proxy_len()).all(|proxy| is_key(proxy) == reconstructs));
    assert_eq!(envelope.groups().count(), envelope.group_len());
    let feature_len = envelope.counts().feature_len();
    for group in envelope.groups() {
        assert!(group.joint < joint_len || joint_len == 0);
        let inputs = (0..group.input_len()).map(|i| group.input(i));
        assert!(inputs.flatten().all(|(feature, _)| feature < feature_len));
    }
    let opened = envelope.layout().open::<Envelope>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == envelope.counts()));
}

fn read_skin(skin: &Skin<'_>, file: &[u8]) {
    let (v, k) = (skin.vertex_len(), skin.influence_len());
    for cost in [24 * v, 6 * v * k, 24 * skin.palette_len()] {
        assert!(cost <= file.len(), "a file of {} bytes costs {cost}", file.len());
    }
    for vertex in 0..v {
        assert!(skin.influences(vertex).all(|(index, _)| index < skin.palette_len()));
        assert!(skin.rest_position(vertex).is_some() && skin.rest_normal(vertex).is_some());
        assert_eq!(skin.rest_tangent(vertex).is_some(), skin.has_tangents());
        let deltas: Vec<_> = skin.deltas_of(vertex).collect();
        assert!(deltas.is_sorted_by_key(|(shape, _)| *shape));
        for (shape, delta) in deltas {
            assert!(skin.shape_box(shape).is_some_and(|bounds| bounds.contains(delta)));
            assert!(skin.shape_slopes(shape, vertex).is_some());
        }
    }
    let ranges: Vec<_> = skin.ranges().map(|(_, range)| range).collect();
    assert_eq!(ranges.len(), skin.counts().range_len as usize);
    assert!(ranges.iter().all(|range| range.start <= range.end && range.end <= v));
    assert!(ranges.windows(2).all(|pair| pair[0].end <= pair[1].start));
    let opened = skin.layout().open::<Skin>(file);
    assert!(opened.is_some_and(|opened| opened.counts() == skin.counts()));
}

/// Evaluates every part of a model: every envelope over the poses and curves numbered by `numbers`
/// (see [`pose`]); every skin; every kernel and every map of views over queries; and every prior
/// over pins.
///
/// # Panics
/// If a call is refused, a result is not finite, a confidence is outside 0 to 1, or a vertex is
/// outside its bounds.
pub fn evaluate<B: AsRef<[u8]>>(model: &Model<B>, numbers: Range<usize>) {
    for envelope in model.all::<Envelope>() {
        for number in numbers.clone() {
            let (pose, curves) = (pose(&envelope, number), curves(&envelope, number));
            evaluate_pose(model, &envelope, number, &pose, &curves);
        }
    }
    for skin in model.all::<Skin>().filter(|skin| skin.envelope_part().is_none()) {
        evaluate_skin(&skin, &[], "at rest");
    }
    for (prior, skin) in
        model.all::<Prior>().filter_map(|prior| Some((prior, model.skin_of(&prior)?)))
    {
        let palette = vec![IDENTITY; skin.palette_len()];
        numbers.clone().for_each(|number| evaluate_prior(&prior, &skin, &palette, number));
    }
    for map in model.all::<KernelMap>() {
        numbers.clone().for_each(|number| evaluate_kernel(&map, number));
    }
    for filter in model.all::<Filter>() {
        numbers.clone().for_each(|number| evaluate_filter(&filter, number));
    }
    for views in model.all::<Views>() {
        numbers.clone().for_each(|number| evaluate_views(model, &views, number));
    }
}

/// Evaluates one pose of an envelope, by number, and the skins that follow the envelope.
///
/// # Panics
/// As [`evaluate`] does.
pub fn evaluate_pose<B: AsRef<[u8]>>(
    model: &Model<B>,
    envelope: &Envelope<'_>,
    number: usize,
    pose: &[Matrix3x4],
    curves: &[f32],
) {
    let named = format!("pose {number} of part {}", envelope.part());
    check(&named, "pose", pose.as_flattened().as_flattened());
    check(&named, "curves", curves);
    let mut scratch = vec![f32::NAN; envelope.scratch_len()];
    let mut palette = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    match envelope.palette(pose, curves, &mut scratch, &mut palette) {
        Ok(confidence) => {
            assert!((0.0..=1.0).contains(&confidence), "{named}: confidence {confidence}");
        }
        Err(error) => panic!("{named}: {error}"),
    }
    check(&named, "palette", palette.as_flattened().as_flattened());
    let mut bones = vec![Trs::IDENTITY; envelope.proxy_len()];
    let confidence = envelope.palette_trs(pose, curves, &mut scratch, &mut palette, &mut bones);
    assert!(confidence.is_ok(), "{named}: {confidence:?}");
    for Trs { translation, rotation, scale } in bones {
        check(&named, "bones", &[&translation[..], &rotation, &scale].concat());
    }
    for skin in model.all::<Skin>().filter(|skin| skin.envelope_part() == Some(envelope.part())) {
        evaluate_skin(&skin, &palette, &named);
    }
}

fn evaluate_skin(skin: &Skin<'_>, palette: &[Matrix3x4], named: &str) {
    check_skinned(skin, skinned(skin, palette, &[]), named);
    if skin.shape_len() > 0 {
        let weight = |shape: usize| [-1.0, 2.0, 0.0, 0.5][shape % 4];
        let weights: Vec<f32> = (0..skin.shape_len()).map(weight).collect();
        check_skinned(skin, skinned(skin, palette, &weights), named);
    }
}

fn check_skinned(skin: &Skin<'_>, found: Result<Skinned, CallError>, named: &str) {
    let (vertices, bounds) = match found {
        Ok(found) => found,
        Err(error) => panic!("{named}: {error}"),
    };
    if let Some(bounds) = bounds {
        check(named, "bounds", &[bounds.min, bounds.max].concat());
    }
    for (vertex, values) in vertices.chunks_exact(stride(skin)).enumerate() {
        check(named, "vertex", values);
        let position = [values[0], values[1], values[2]];
        let within = bounds.is_some_and(|bounds| bounds.contains(position));
        assert!(within, "{named}: vertex {vertex} at {position:?} is outside {bounds:?}");
    }
}

fn check(named: &str, what: &str, values: &[f32]) {
    let unsound = values.iter().position(|x| !x.is_finite());
    assert!(unsound.is_none(), "{named}: {what} {unsound:?} is not finite");
}

/// Floats of the vertices, and the bounds.
type Skinned = (Vec<f32>, Option<Bounds>);

/// Skins a mesh, with shapes if there are weights. Returns position, normal and, if present,
/// tangent of each vertex (NaN where nothing was written), and the bounds.
fn skinned(skin: &Skin<'_>, palette: &[Matrix3x4], weights: &[f32]) -> Result<Skinned, CallError> {
    let (stride, v) = (stride(skin), skin.vertex_len());
    let (mut positions, mut normals) = (vec![[f32::NAN; 3]; v], vec![[f32::NAN; 3]; v]);
    let mut tangents = vec![[f32::NAN; 4]; if skin.has_tangents() { v } else { 0 }];
    let mut rest = Rest::default();
    if !weights.is_empty() {
        let to = |floats, stride| Some(Output::new(floats, stride));
        ShapesJob::new(*skin, weights)
            .positions(to(positions.as_flattened_mut(), 3))
            .normals(to(normals.as_flattened_mut(), 3))
            .tangents(to(tangents.as_flattened_mut(), 4).filter(|_| skin.has_tangents()))
            .run()?;
        let all = [positions.as_flattened(), normals.as_flattened(), tangents.as_flattened()];
        all.into_iter().for_each(|floats| check("at rest", "shaped vertex", floats));
        rest.positions = Some(&positions);
        rest.normals = Some(&normals);
        rest.tangents = skin.has_tangents().then_some(&tangents);
    }
    let mut out = vec![f32::NAN; stride * skin.vertex_len()];
    let lent = cells(&mut out);
    let attribute = |start: usize| {
        let floats = lent.get(start..).unwrap_or_default();
        Some(Output::shared(floats, stride))
    };
    rest.of(SkinJob::new(*skin, palette))
        .positions(attribute(0))
        .normals(attribute(3))
        .tangents(attribute(6).filter(|_| skin.has_tangents()))
        .run()?;
    let bounds = match weights {
        [] => skin.bounds(palette, 0.0)?,
        _ => skin.shaped_bounds(palette, weights)?,
    };
    Ok((out, bounds))
}

/// Returns the floats per vertex.
const fn stride(skin: &Skin<'_>) -> usize {
    if skin.has_tangents() { 10 } else { 6 }
}
