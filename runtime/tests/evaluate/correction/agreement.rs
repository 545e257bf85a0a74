//! The correction against an independent evaluation in f64.

use super::reference::{narrow, reference, reference_features, rigid};
use super::{base, features, flat};
use crate::common::{
    apart, confident_palette, max_difference, palette_with, random_pose, stretched_pose,
    with_predictor,
};
use models::{GroupContent, JOINTLESS, Pieces, Rng, SMALL, STRETCHING, Shape, sample_groups};
use sinew_runtime::envelope::{GroupKernel, Predictor};
use sinew_runtime::{Envelope, Model};

#[test]
fn features_agree_with_f64() {
    for shape in [SMALL, STRETCHING, JOINTLESS] {
        let shape = Shape { joints: 3 * shape.joints / 2, ..shape };
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let mut rng = Rng(3);
            for _ in (0..200).step_by(apart(50)) {
                let at = stretched_pose(&envelope, &mut rng, 1.0);
                let found = features(&envelope, &at.pose, &at.curves);
                let expected = reference_features(&at, shape.stretches);
                let expected = expected.iter().map(|&x| x as f32).collect::<Vec<_>>();
                let difference = max_difference(&found, &expected);
                // About ten roundings of displacements up to 10; rotations of joints that stretch are
                // off by some more.
                let most = if shape.stretches { 1e-4 } else { 1e-5 };
                assert!(difference < most, "{difference}");
                if shape.joints > 0 {
                    assert_eq!(found[12 * envelope.root()..][..12], [0.0; 12]);
                }
            }
        });
    }
}

#[test]
fn corrections_agree_with_f64() {
    let wide_shape =
        Shape { vertices: 3, joints: 7, proxies: 9, influences: 3, tangents: false, ..SMALL };
    for shape in [SMALL, wide_shape, STRETCHING, JOINTLESS] {
        let groups = sample_groups(shape);
        let is_rigid = !shape.stretches && shape.curves == 0;
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let mut rng = Rng(11);
            let mut between = 0;
            for i in (0..300).step_by(apart(149)) {
                let turn = [0.05, 0.2, 0.5][i % 3];
                let at = stretched_pose(&envelope, &mut rng, turn);
                let base = base(&groups, &at.pose);
                let (found, confidence) = palette_with(&envelope, &at.pose, &at.curves);
                let phi = reference_features(&at, shape.stretches);
                let (expected, expected_confidence) = reference(&groups, &at.pose, &phi, &base);
                let expected = narrow(&expected);
                let largest = expected.iter().fold(1.0f32, |a, x| a.max(x.abs()));
                let difference = max_difference(flat(&found), &expected);
                // About 50 roundings of terms close to the largest; rotations of joints that stretch
                // are off by some more.
                let most = if shape.stretches { 1e-4 } else { 4e-6 };
                assert!(difference < most * largest, "{difference} of {largest}");
                // Strains and curves have ranges, which lower the confidence further.
                let difference = f64::from(confidence) - expected_confidence;
                let is_lower = !is_rigid && difference < 1e-4;
                assert!(is_lower || difference.abs() < 2e-6, "{confidence} {expected_confidence}");
                between += usize::from(confidence > 0.01 && confidence < 0.99);
            }
            assert!(
                cfg!(miri) || between > 50 || !is_rigid,
                "{between} poses have a confidence between 0 and 1"
            );
        });
    }
}

#[test]
fn each_number_of_a_group_matters() {
    let groups = sample_groups(SMALL);
    let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
    let pose_of = |envelope: &Envelope<'_>| random_pose(envelope, &mut Rng(8), 0.5);
    let evaluate = |pieces: &Pieces| {
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let (palette, confidence) = confident_palette(&envelope, &pose_of(&envelope));
        [flat(&palette), &[confidence]].concat()
    };
    let still = evaluate(&pieces);
    let edits = [
        (|g| g.inputs[1].0 += 1) as fn(&mut GroupContent),
        |g| g.inputs[1].1 += 0.1,
        |g| g.centres[10][4] += 0.1,
        |g| g.coefficients[2][0] += 0.1,
        |g| g.coefficients[2][10] += 0.1,
        |g| g.coefficients[2][11] += 0.1,
        |g| g.coefficients[0][12] += 0.1,
        |g| g.outputs[11][2] += 0.1,
        |g| g.joint = 2,
        |g| g.confidence.reach = 1e-3,
        |g| g.confidence.linear = 0.5,
        |g| g.confidence.signal = 1.0,
        |g| g.confidence.noise = 1.0,
        |g| g.coefficients[3][2] += 0.5,
        |g| g.coefficients[4][13] += 0.5,
        |g| g.kernel = GroupKernel::Matern32,
    ];
    for (index, edit) in edits.into_iter().enumerate() {
        let mut groups = groups.clone();
        assert_ne!(groups[0].kernel, GroupKernel::Matern32);
        edit(&mut groups[0]);
        pieces.set_groups(&groups);
        let difference = max_difference(&evaluate(&pieces), &still);
        assert!(difference > 1e-5, "edit {index}: {difference}");
    }
}

#[test]
fn groups_without_centres_add_nothing_and_have_no_confidence() {
    let mut groups = sample_groups(SMALL);
    groups[1].centres.clear();
    groups[1].coefficients.iter_mut().for_each(|row| row.truncate(9));
    for groups in [vec![groups[0].clone(), groups[1].clone()], {
        let mut all = groups.clone();
        all[0].centres.clear();
        all[0].coefficients.iter_mut().for_each(|row| row.truncate(5));
        all
    }] {
        let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
        pieces.set_groups(&groups);
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let pose = random_pose(&envelope, &mut Rng(4), 0.3);
        let (palette, confidence) = confident_palette(&envelope, &pose);
        let base = base(&groups, &pose);
        let phi = reference_features(&rigid(&pose), false);
        let (expected, expected_confidence) = reference(&groups, &pose, &phi, &base);
        assert!(max_difference(flat(&palette), &narrow(&expected)) < 2e-5);
        assert!((f64::from(confidence) - expected_confidence).abs() < 2e-6);
        assert_eq!(palette[5..], base[5..], "the second group's helpers");
        assert_eq!(palette[4] == base[4], groups[0].centres.is_empty());
    }
}
