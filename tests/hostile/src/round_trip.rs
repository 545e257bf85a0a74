//! Random round trips: the trainer bakes a random small description, the runtime loads it, and the
//! values must agree.

use crate::evaluate::{evaluate, read};
use arbitrary::{Result, Unstructured};
use faer::Mat;
use nalgebra::{Matrix3, SMatrix};
use sinew_runtime::envelope::{
    Certificate, GroupConfidence, GroupKernel, HelperKind, NO_JOINT, Predictor, TWIST_MAX,
};
use sinew_runtime::format::{Axis, CORRECTION_MAX, Handedness, MAGNITUDE_MAX, Space};
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::envelope::model::{
    Curve, EnvelopeModel, Feature, FeatureOrder, FileModel, Group, Input, Key, Reconstruction,
    ShapeNumbers, Shapes, Shear, SkinModel,
};
use sinew_trainer::examples::Skeleton;
use sinew_trainer::numeric::trs::Place;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;
use std::ops::Range;

/// Bakes the description that the bytes define, loads it, compares the values and evaluates the
/// model.
///
/// # Errors
/// The reason why the description cannot be baked; most descriptions can.
///
/// # Panics
/// If the file gives other values than the description.
pub fn round_trip(data: &[u8]) -> std::result::Result<(), sinew_trainer::Error> {
    let mut u = Unstructured::new(data);
    // Missing bytes are read as zeros, so all bytes are a description.
    let Ok(parts) = file_model(&mut u) else { return Ok(()) };
    let model = Model::from_bytes(parts.bake()?)?;
    read(&model);
    assert_eq!(model.space(), parts.space);
    let counts = (model.all::<Envelope>().count(), model.all::<Skin>().count());
    assert_eq!(counts, (parts.envelopes.len(), parts.skins.len()));
    for (parts, envelope) in parts.envelopes.iter().zip(model.all::<Envelope>()) {
        compare(parts, &envelope);
    }
    for (parts, skin) in parts.skins.iter().zip(model.all::<Skin>()) {
        assert_eq!(skin.envelope_part(), parts.envelope);
        compare_skin(parts, &skin);
    }
    evaluate(&model, 0..crate::poses::KINDS);
    Ok(())
}

fn file_model(u: &mut Unstructured<'_>) -> Result<FileModel> {
    // The trainer writes envelopes first, so the index of an envelope is the index of its part.
    let envelope_len = u.int_in_range(0..=2)?;
    let envelopes = list(envelope_len, || envelope(u))?;
    let skin_len = u.int_in_range(usize::from(envelope_len == 0)..=3)?;
    let skins = list(skin_len, || skin(&envelopes, u))?;
    Ok(FileModel { space: space(u)?, envelopes, skins, ..FileModel::default() })
}

fn space(u: &mut Unstructured<'_>) -> Result<Space> {
    let up = if u.arbitrary()? { Some(*u.choose(&Axis::ALL)?) } else { None };
    let forward = if u.arbitrary()? { Some(*u.choose(&Axis::ALL)?) } else { None };
    let forward = forward.filter(|forward| up.is_none_or(|up| !up.is_along(*forward)));
    let handedness = *u.choose(&[Handedness::Right, Handedness::Left])?;
    let unit = if u.arbitrary()? { Some(*u.choose(&[1e-9, 0.01, 1.0, 1e9])?) } else { None };
    Ok(Space { up, forward, handedness, unit })
}

fn envelope(u: &mut Unstructured<'_>) -> Result<EnvelopeModel> {
    let predictor = *u.choose(&Predictor::ALL)?;
    // Curves alone may move a kernel envelope, and only a kernel envelope has curves.
    let joint_len = u.int_in_range(usize::from(!predictor.corrects())..=6)?;
    let least = usize::from(joint_len == 0);
    let curve_len = if predictor.corrects() { u.int_in_range(least..=3)? } else { 0 };
    let proxy_len = u.int_in_range(1..=4)?;
    let order = FeatureOrder { joint_len, stretches: joint_len > 0 && u.arbitrary()? };
    let feature_len = order.index(Feature::Curve(curve_len));
    // A tree whose joints are renumbered cyclically.
    let turn = u.choose_index(joint_len.max(1))?;
    let number = |joint: usize| (joint + turn) % joint_len;
    let mut parents = vec![None; joint_len];
    for joint in 1..joint_len {
        parents[number(joint)] = Some(number(u.choose_index(joint)?));
    }
    let reconstruction = if predictor.reconstructs() {
        let keys = list(proxy_len, || key(order, u))?;
        let c1 = matrix(4 * proxy_len, 3 * proxy_len, || float(u, MAGNITUDE_MAX))?;
        let c2 = matrix(4 * proxy_len, 4 * joint_len, || float(u, MAGNITUDE_MAX))?;
        Some(Reconstruction { keys, c1, c2 })
    } else {
        None
    };
    let mut groups = Vec::new();
    let mut first = if predictor.corrects() { 0 } else { proxy_len };
    while first < proxy_len {
        let group = group((order, feature_len), first..proxy_len, u)?;
        first = group.proxies.end;
        groups.push(group);
    }
    Ok(EnvelopeModel {
        name: name(u)?,
        skeleton: Skeleton {
            names: list(joint_len, || name(u))?,
            parents,
            rest: list(joint_len, || frame(u))?,
            is_still: joint_len == 0,
            ..Skeleton::default()
        },
        reconstruction,
        groups,
        helper_kind: if predictor.corrects() {
            *u.choose(&HelperKind::ALL)?
        } else {
            HelperKind::Affine
        },
        places: list(proxy_len, || place(u))?,
        stretch_ranges: match order.stretches {
            true => Some(list(joint_len, || float(u, 4.0).map(f64::abs))?),
            false => None,
        },
        curves: list(curve_len, || {
            let (a, b) = (float(u, MAGNITUDE_MAX)?, float(u, MAGNITUDE_MAX)?);
            Ok(Curve { name: name(u)?, range: [a.min(b), a.max(b)] })
        })?,
        pose_ranges: list(joint_len, || float(u, 4.0).map(f64::abs))?,
        pose_gaps: list(joint_len, || float(u, 4.0).map(f64::abs))?,
        certificate: Certificate { diagonal: float(u, 1e3)? as f32, ..Certificate::default() },
    })
}

/// Describes the place of a helper, with the spread of rounded numbers.
fn place(u: &mut Unstructured<'_>) -> Result<Place> {
    let mut number = || Ok(f64::from(float(u, MAGNITUDE_MAX)? as f32));
    let centre = [number()?, number()?, number()?];
    Ok(Place { spread: Matrix3::from_diagonal_element(0.25), ..Place::at(centre) })
}

/// Describes a skin that follows one of the envelopes, or none.
fn skin(envelopes: &[EnvelopeModel], u: &mut Unstructured<'_>) -> Result<SkinModel> {
    let vertex_len = u.int_in_range(0..=9)?;
    let number = u.choose_index(envelopes.len() + 1)?;
    let envelope = envelopes.get(number);
    let influence_len = u.int_in_range(1..=5)?;
    let influences = match envelope.map(EnvelopeModel::palette_len) {
        None => Vec::new(),
        Some(palette_len) => list(vertex_len, || {
            let len = u.int_in_range(1..=influence_len)?;
            list(len, || {
                let index = u.choose_index(palette_len)?;
                Ok((index, f64::from(u.int_in_range(1..=1000u16)?)))
            })
        })?,
    };
    let mut start = 0;
    let ranges = list(u.choose_index(3)?, || {
        let first = u.int_in_range(start..=vertex_len)?;
        start = u.int_in_range(first..=vertex_len)?;
        Ok((name(u)?, first..start))
    })?;
    Ok(SkinModel {
        name: name(u)?,
        envelope: envelope.map(|_| number),
        rest_positions: list(vertex_len, || vector(u, MAGNITUDE_MAX))?,
        rest_normals: list(vertex_len, || Ok(direction(u)?.unwrap_or_default()))?,
        rest_tangents: if u.arbitrary()? {
            let tangent = |[x, y, z]: [f64; 3]| [x, y, z, if x < 0.5 { -1.0 } else { 1.0 }];
            let along = [1.0, 0.0, 0.0];
            Some(list(vertex_len, || Ok(tangent(direction(u)?.unwrap_or(along))))?)
        } else {
            None
        },
        influences,
        tangent_coefficients: None,
        normal_errors: None,
        ranges,
        shapes: shapes(vertex_len, u)?,
    })
}

/// Describes up to three shapes; each leaves some vertices unmoved.
fn shapes(vertex_len: usize, u: &mut Unstructured<'_>) -> Result<Shapes> {
    let names = list(u.choose_index(4)?, || name(u))?;
    let moved = |u: &mut Unstructured<'_>| -> Result<[f64; 3]> {
        if u.arbitrary()? { vector(u, 1e6) } else { Ok([0.0; 3]) }
    };
    Ok(Shapes {
        deltas: list(names.len(), || list(vertex_len, || moved(u)))?,
        slopes: list(names.len(), || list(vertex_len, || moved(u).map(|[a, c, _]| [a, c])))?,
        numbers: *u.choose(&[ShapeNumbers::F32, ShapeNumbers::F16, ShapeNumbers::I8])?,
        names,
    })
}

fn key(order: FeatureOrder, u: &mut Unstructured<'_>) -> Result<Key> {
    let FeatureOrder { joint_len, stretches } = order;
    // Nine entries of a third of the norm reach the norm.
    let most = 0.33 * TWIST_MAX;
    let matrix = |u: &mut Unstructured<'_>| -> Result<Matrix3<f64>> {
        let rows = [vector(u, most)?, vector(u, most)?, vector(u, most)?];
        Ok(Matrix3::from_fn(|r, c| rows[r][c]))
    };
    let twist = matrix(u)?;
    let residual =
        if u.arbitrary()? { Some((u.choose_index(joint_len)?, matrix(u)?)) } else { None };
    let mut shear = Shear::zeros();
    // The first six columns come first; the others belong to strains.
    for entry in shear.iter_mut().take(if stretches { 72 } else { 36 }) {
        *entry = float(u, MAGNITUDE_MAX)?;
    }
    Ok(Key { joint: u.choose_index(joint_len)?, twist, residual, shear })
}

fn group(
    (order, feature_len): (FeatureOrder, usize),
    left: Range<usize>,
    u: &mut Unstructured<'_>,
) -> Result<Group> {
    let proxies = left.start..left.start + u.int_in_range(1..=left.len())?;
    let rows = 12 * proxies.len();
    let [d, r] = [u.int_in_range(1..=10)?, u.int_in_range(1..=9)?];
    let n = u.int_in_range(0..=10)?;
    let len = u.int_in_range(0..=9)?;
    let share =
        |u: &mut Unstructured<'_>| Ok::<_, arbitrary::Error>(float(u, CORRECTION_MAX)?.abs());
    let [linear, signal, noise] = [share(u)?, share(u)?, share(u)?];
    let reach = 0.5 * share(u)? + 1.0;
    let kernel = *u.choose(&GroupKernel::ALL)?;
    // A file has twice the centres of a gaussian and the sums of their squares: ten coordinates here at most.
    let most = if kernel == GroupKernel::Gaussian { 300.0 } else { CORRECTION_MAX };
    Ok(Group {
        joint: u.choose_index(order.joint_len.max(1))?,
        proxies,
        inputs: list(d, || {
            let feature = order.feature(u.choose_index(feature_len)?);
            Ok(Input { feature, weight: float(u, CORRECTION_MAX)? })
        })?,
        map: KernelMap {
            kernel,
            // Squares and sums of these values stay finite, so a far centre's kernel at rest is a
            // number.
            centres: matrix(d, n, || float(u, most))?,
            coefficients: matrix(r + len, n + d, || float(u, CORRECTION_MAX))?,
            confidence: MapConfidence { len, reach, linear, signal, noise },
        },
        outputs: matrix(rows, r, || float(u, CORRECTION_MAX))?,
    })
}

/// Compares a matrix with the file's, entry by entry.
fn compare_entries(what: &str, expected: &Mat<f64>, found: impl Fn(usize, usize) -> Option<f32>) {
    for (r, c) in (0..expected.nrows()).flat_map(|r| (0..expected.ncols()).map(move |c| (r, c))) {
        assert_eq!(found(r, c), Some(expected[(r, c)] as f32), "{what}, row {r}, column {c}");
    }
}

/// Rounds the rows of a matrix.
fn rows<const N: usize>(matrix: &SMatrix<f64, N, N>) -> [[f32; N]; N] {
    std::array::from_fn(|r| std::array::from_fn(|c| matrix[(r, c)] as f32))
}

/// Draws a matrix row by row.
fn matrix(rows: usize, columns: usize, mut entry: impl FnMut() -> Result<f64>) -> Result<Mat<f64>> {
    let mut out = Mat::zeros(rows, columns);
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        out[(r, c)] = entry()?;
    }
    Ok(out)
}

/// Draws a rigid frame: a rotation about one of the three axes, and an origin.
fn frame(u: &mut Unstructured<'_>) -> Result<[[f64; 4]; 3]> {
    let [x, y, z] = vector(u, 1e6)?;
    let (s, c) = float(u, 4.0)?.sin_cos();
    Ok(match u.int_in_range(0..=2)? {
        0 => [[1.0, 0.0, 0.0, x], [0.0, c, -s, y], [0.0, s, c, z]],
        1 => [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]],
        _ => [[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z]],
    })
}

/// Draws a direction of length 1; rarely `None`.
fn direction(u: &mut Unstructured<'_>) -> Result<Option<[f64; 3]>> {
    let v = vector(u, 1.0)?;
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    Ok((length > 1e-3).then(|| v.map(|x| x / length)))
}

fn vector(u: &mut Unstructured<'_>, most: f32) -> Result<[f64; 3]> {
    Ok([float(u, most)?, float(u, most)?, float(u, most)?])
}

/// Draws a number within ±`most`; every fourth is ±`most`.
fn float(u: &mut Unstructured<'_>, most: f32) -> Result<f64> {
    let share = match u.arbitrary::<i16>()? {
        bits if bits & 3 == 0 => f64::from(bits.signum()),
        bits => f64::from(bits) / 32_768.0,
    };
    Ok(share * f64::from(most))
}

fn name(u: &mut Unstructured<'_>) -> Result<String> {
    let len = u.int_in_range(0..=6)?;
    (0..len).map(|_| u.arbitrary::<char>()).collect()
}

fn list<T>(len: usize, mut make: impl FnMut() -> Result<T>) -> Result<Vec<T>> {
    (0..len).map(|_| make()).collect()
}

/// Compares each array of an envelope with its rounded description.
fn compare(parts: &EnvelopeModel, envelope: &Envelope<'_>) {
    let round = |x: f64| x as f32;
    assert_eq!(envelope.name(), parts.name);
    assert_eq!((envelope.predictor(), envelope.root()), (parts.predictor(), parts.skeleton.root()));
    let Skeleton { names, parents, rest, .. } = &parts.skeleton;
    assert_eq!(envelope.joint_len(), parents.len());
    assert_eq!(envelope.certificate(), parts.certificate);
    for (joint, parent) in parents.iter().enumerate() {
        assert_eq!(envelope.joint_name(joint), Some(names[joint].as_str()));
        assert_eq!(envelope.parent(joint), *parent);
        assert_eq!(envelope.pose_range(joint), Some(round(parts.pose_ranges[joint])));
        assert_eq!(envelope.pose_gap(joint), Some(round(parts.pose_gaps[joint])));
        let origin = rest[joint].map(|row| round(row[3]));
        assert_eq!(envelope.origin(joint), parts.predictor().corrects().then_some(origin));
    }
    assert_eq!(envelope.stretches(), parts.stretch_ranges.is_some());
    for (joint, range) in parts.stretch_ranges.iter().flatten().enumerate() {
        assert_eq!(envelope.stretch_range(joint), Some(round(*range)));
    }
    assert_eq!(envelope.helper_kind(), parts.helper_kind);
    for (helper, place) in parts.places.iter().enumerate() {
        let centre = <[f64; 3]>::from(place.centre).map(round);
        assert_eq!(envelope.helper_centre(helper), Some(centre));
        let spread = [0.25, 0.0, 0.0, 0.25, 0.0, 0.25];
        assert_eq!(envelope.helper_spread(helper), Some(spread));
    }
    assert_eq!(envelope.curve_len(), parts.curves.len());
    for (curve, Curve { name, range }) in parts.curves.iter().enumerate() {
        assert_eq!(envelope.curve_name(curve), Some(name.as_str()));
        assert_eq!(envelope.curve_range(curve), Some(range.map(round)));
    }
    compare_reconstruction(parts, envelope);
    compare_groups(parts, envelope);
}

/// Compares each array of a skin with its rounded description.
fn compare_skin(parts: &SkinModel, skin: &Skin<'_>) {
    let round = |x: f64| x as f32;
    assert_eq!((skin.name(), skin.vertex_len()), (&*parts.name, parts.rest_positions.len()));
    for vertex in 0..skin.vertex_len() {
        assert_eq!(skin.rest_position(vertex), Some(parts.rest_positions[vertex].map(round)));
        assert_eq!(skin.rest_normal(vertex), Some(parts.rest_normals[vertex].map(round)));
        let tangent = parts.rest_tangents.as_ref().map(|t| t[vertex].map(round));
        assert_eq!(skin.rest_tangent(vertex), tangent);
    }
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let sum = influences.iter().map(|&(_, weight)| weight).sum::<f64>();
        // The order is the writer's.
        let mut expected = std::collections::BTreeMap::<usize, f64>::new();
        for &(index, weight) in influences {
            *expected.entry(index).or_default() += weight / sum;
        }
        let expected = expected.into_iter().map(|(index, weight)| (index, round(weight)));
        let mut found: Vec<_> = skin.influences(vertex).filter(|(_, w)| *w > 0.0).collect();
        found.sort_by_key(|(index, _)| *index);
        let used = expected.filter(|(_, weight)| *weight > 0.0);
        assert!(used.eq(found), "influences of vertex {vertex}");
    }
    let ranges = skin.ranges().map(|(name, range)| (name.to_owned(), range));
    assert!(ranges.eq(parts.ranges.iter().cloned()));
    compare_shapes(&parts.shapes, skin);
}

/// Compares shapes: f32 values with the rounded description, smaller types within the precision
/// that the file states.
fn compare_shapes(parts: &Shapes, skin: &Skin<'_>) {
    assert_eq!(skin.shape_len(), parts.names.len());
    let most = skin.shape_errors().map_or(0.0, |errors| errors.largest);
    for (shape, name) in parts.names.iter().enumerate() {
        assert_eq!(skin.shape_name(shape), Some(name.as_str()));
        for (vertex, delta) in parts.deltas[shape].iter().enumerate() {
            let found = skin.shape_delta(shape, vertex).unwrap_or([f32::NAN; 3]);
            let error = found.iter().zip(delta).map(|(x, y)| (f64::from(*x) - y).abs());
            let error = error.fold(0.0, f64::max);
            assert!(error <= f64::from(most) * 1.001, "{error} {most}");
            if parts.numbers == ShapeNumbers::F32 {
                assert_eq!(found, delta.map(|x| x as f32));
                let slopes = parts.slopes[shape][vertex].map(|x| x as f32);
                assert_eq!(skin.shape_slopes(shape, vertex), Some(slopes));
            }
        }
    }
}

fn compare_reconstruction(parts: &EnvelopeModel, envelope: &Envelope<'_>) {
    let Some(Reconstruction { keys, c1, c2 }) = &parts.reconstruction else {
        assert_eq!((envelope.key(0), envelope.c1(0, 0), envelope.c2(0, 0)), (None, None, None));
        return;
    };
    for (proxy, key) in keys.iter().enumerate() {
        let found = envelope.key(proxy);
        let expected = sinew_runtime::envelope::Key {
            joint: key.joint,
            twist: rows(&key.twist),
            residual: key.residual.map(|(joint, m)| (joint, rows(&m))),
            shear: rows(&key.shear.fixed_columns::<6>(0).into_owned()),
            stretch: parts
                .stretch_ranges
                .as_ref()
                .map(|_| rows(&key.shear.fixed_columns::<6>(6).into_owned())),
        };
        assert_eq!(found, Some(expected), "key {proxy}");
    }
    compare_entries("c1", c1, |r, c| envelope.c1(r, c));
    compare_entries("c2", c2, |r, c| envelope.c2(r, c));
}

fn compare_groups(parts: &EnvelopeModel, envelope: &Envelope<'_>) {
    let (round, order) = (|x: f64| x as f32, parts.feature_order());
    assert_eq!(envelope.group_len(), parts.groups.len());
    for (group, found) in parts.groups.iter().zip(envelope.groups()) {
        let Group { inputs, map: KernelMap { kernel, centres, coefficients, confidence }, .. } =
            group;
        let (d, n, r) = (inputs.len(), centres.ncols(), group.outputs.ncols());
        let joint = if order.joint_len > 0 { group.joint } else { NO_JOINT.into() };
        assert_eq!((found.joint, found.kernel), (joint, *kernel));
        assert_eq!(found.proxies, group.proxies);
        assert_eq!((found.input_len(), found.centre_len(), found.rank()), (d, n, r));
        let MapConfidence { len, reach, linear, signal, noise } = *confidence;
        let [reach, linear, signal, noise] = [reach, linear, signal, noise].map(round);
        assert_eq!(
            (found.certainty_len(), found.confidence),
            (len, GroupConfidence { reach, linear, signal, noise })
        );
        for (i, &Input { feature, weight }) in inputs.iter().enumerate() {
            assert_eq!(found.input(i), Some((order.index(feature), round(weight))));
        }
        compare_entries("centres", centres, |i, k| found.centre(k, i));
        compare_entries("coefficients", coefficients, |r, c| found.coefficient(r, c));
        compare_entries("outputs", &group.outputs, |r, c| found.output(r, c));
    }
}
