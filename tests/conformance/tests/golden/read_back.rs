//! Baked parts, as the runtime reads them.

use super::sample::{Golden, file_model, goldens};
use faer::Mat;
use nalgebra::SMatrix;
use sinew_runtime::envelope::{GroupConfidence, GroupKernel};
use sinew_runtime::format::ALIGNMENT;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::envelope::model::{EnvelopeModel, Input, SkinModel};
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;

#[test]
fn baked_parts_are_read_back() {
    goldens().for_each(read_back);
}

fn read_back(golden: Golden) {
    let parts = file_model(golden);
    let bytes = parts.bake().unwrap();
    let model = Model::from_bytes(bytes.as_slice()).unwrap();
    assert_eq!(model.space(), parts.space);
    for section in model.sections() {
        let offset = section.bytes.as_ptr().addr() - bytes.as_ptr().addr();
        assert!(offset.is_multiple_of(ALIGNMENT), "sections are aligned in the file");
    }
    read_back_envelope(&parts.envelopes[0], model.named::<Envelope>("golden").unwrap());
    let skin = model.named::<Skin>("golden skin").unwrap();
    read_back_skin(&parts.skins[0], skin);
    assert_eq!(model.envelope_of(&skin).map(|found| found.part()), Some(0));
}

fn read_back_envelope(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    assert_eq!(envelope.parent(0), Some(1));
    assert_eq!(envelope.joint_name(3), Some("hip"));
    assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [3, 2, 4, 1, 0]);
    // The inverse of a quarter turn about z at (x, 0.5, 0).
    let inverse = [[0.0, 1.0, 0.0, -0.5], [-1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 0.0]];
    assert_eq!(envelope.inverse_bind(2), Some(inverse));
    assert_eq!(envelope.predictor(), parts.predictor());
    assert_eq!(envelope.certificate(), parts.certificate);
    assert_eq!(envelope.helper_kind(), parts.helper_kind);
    assert_eq!(EnvelopeModel::from_file(&envelope).places, parts.places);
    read_back_groups(parts, envelope);
    read_back_movements(parts, envelope);
    for (l, key) in parts.keys().iter().enumerate() {
        let found = envelope.key(l).unwrap();
        assert_eq!(found.joint, key.joint);
        assert_eq!(wide(found.twist), key.twist);
        assert_eq!(wide(found.shear), key.shear.fixed_columns::<6>(0).into_owned());
        let strains = parts.stretch_ranges.as_ref();
        let strains = strains.map(|_| key.shear.fixed_columns::<6>(6).into_owned());
        assert_eq!(found.stretch.map(wide), strains);
        assert_eq!(found.residual.map(|(j, m)| (j, wide(m))), key.residual);
    }
    let base = parts.reconstruction.as_ref();
    for (row, column) in (0..20).flat_map(|row| (0..20).map(move |column| (row, column))) {
        let c1 = base.filter(|_| column < 15).map(|base| base.c1[(row, column)]);
        let c2 = base.map(|base| base.c2[(row, column)]);
        assert_eq!(envelope.c1(row, column).map(f64::from), c1);
        assert_eq!(envelope.c2(row, column).map(f64::from), c2);
    }
}

fn read_back_groups(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    let order = parts.feature_order();
    assert_eq!(envelope.group_len(), parts.groups.len());
    for (joint, [x, y, z]) in parts.skeleton.rest.iter().enumerate() {
        let origin = envelope.origin(joint).map(|o| o.map(f64::from));
        assert_eq!(origin, (!parts.groups.is_empty()).then_some([x[3], y[3], z[3]]));
    }
    for (found, group) in envelope.groups().zip(&parts.groups) {
        let KernelMap { kernel, centres, coefficients, confidence } = &group.map;
        let dense = |like: &Mat<f64>, entry: &dyn Fn(usize, usize) -> Option<f32>| {
            Mat::from_fn(like.nrows(), like.ncols(), |r, c| f64::from(entry(r, c).unwrap()))
        };
        assert_eq!((found.joint, found.kernel), (group.joint, *kernel));
        assert_eq!(found.proxies, group.proxies);
        let GroupConfidence { reach, linear, signal, noise } = found.confidence;
        let read = MapConfidence {
            len: found.certainty_len(),
            reach: reach.into(),
            linear: linear.into(),
            signal: signal.into(),
            noise: noise.into(),
        };
        assert_eq!(read, *confidence);
        for (i, &Input { feature, weight }) in group.inputs.iter().enumerate() {
            assert_eq!(found.input(i), Some((order.index(feature), weight as f32)));
        }
        assert_eq!(&dense(centres, &|i, k| found.centre(k, i)), centres);
        // A gaussian has the squared distance at rest. Every other kernel is 1 at the centre, and falls from there.
        let is_sound = |k| {
            let (rest, squared) = (found.rest(k).unwrap(), centres.col(k).squared_norm_l2() as f32);
            let is_near = (rest / squared - 1.0).abs() < 1e-6;
            if *kernel == GroupKernel::Gaussian { is_near } else { (0.0..1.0).contains(&rest) }
        };
        assert!((0..centres.ncols()).all(is_sound));
        assert_eq!(&dense(coefficients, &|r, c| found.coefficient(r, c)), coefficients);
        assert_eq!(&dense(&group.outputs, &|r, c| found.output(r, c)), &group.outputs);
    }
}

/// Compares the ranges of stretches, and the curves.
fn read_back_movements(parts: &EnvelopeModel, envelope: Envelope<'_>) {
    assert_eq!(envelope.stretches(), parts.stretch_ranges.is_some());
    for joint in 0..parts.joint_len() {
        let range = parts.stretch_ranges.as_ref().map_or(0.0, |ranges| ranges[joint]);
        assert_eq!(envelope.stretch_range(joint).map(f64::from), Some(range));
    }
    assert_eq!(envelope.curve_len(), parts.curves.len());
    for (index, curve) in parts.curves.iter().enumerate() {
        assert_eq!(envelope.curve_name(index), Some(&*curve.name));
        assert_eq!(
            envelope.curve_range(index).map(|range| range.map(f64::from)),
            Some(curve.range)
        );
    }
}

fn read_back_skin(parts: &SkinModel, skin: Skin<'_>) {
    let ranges = skin.ranges().map(|(name, range)| (name.to_owned(), range));
    assert_eq!(ranges.collect::<Vec<_>>(), parts.ranges);
    assert_eq!(skin.vertex_len(), parts.rest_positions.len());
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let found = skin.influences(vertex).filter(|(_, weight)| *weight > 0.0);
        // The file has them in an order of its own.
        let found = found.map(|(index, weight)| (index, f64::from(weight)));
        assert_eq!(sorted(found), sorted(influences.iter().copied()));
        let wide = |x: [f32; 3]| x.map(f64::from);
        assert_eq!(skin.rest_position(vertex).map(wide), Some(parts.rest_positions[vertex]));
        assert_eq!(skin.rest_normal(vertex).map(wide), Some(parts.rest_normals[vertex]));
        let tangent = skin.rest_tangent(vertex).map(|t| t.map(f64::from));
        assert_eq!(tangent, parts.rest_tangents.as_ref().map(|tangents| tangents[vertex]));
    }
}

fn sorted(influences: impl Iterator<Item = (usize, f64)>) -> Vec<(usize, f64)> {
    let mut all: Vec<_> = influences.collect();
    all.sort_by_key(|influence| influence.0);
    all
}

fn wide<const N: usize>(rows: [[f32; N]; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|r, c| f64::from(rows[r][c]))
}
