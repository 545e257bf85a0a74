//! Joints and curves inside and outside their trained ranges, and joints that are hidden or mirrored.

use super::{features, flat};
use crate::common::{
    IDENTITY, Stretched, confident_palette, max_difference, palette_with, random_pose,
    stretched_pose, with_predictor,
};
use models::{Pieces, Rng, SMALL, STRETCHING, Shape, sample_groups};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Matrix3x4, Model, stages};

#[test]
fn a_rotational_model_is_confident_within_its_ranges() {
    // The sample's ranges are 1.5, so the confidence reaches 0 at 1.5 + 0.85.
    with_predictor(Predictor::Rotational, SMALL, |envelope| {
        let turned = |angle: f32| {
            let (s, c) = angle.sin_cos();
            let mut pose = vec![IDENTITY; 4];
            pose[3] = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            confident_palette(&envelope, &pose).1
        };
        assert_eq!([0.0, 1.0, 1.499, 2.351, 3.0].map(turned), [1.0, 1.0, 1.0, 0.0, 0.0]);
        // Half of the way, and a quarter of the way: 1 - (10/64 - 15/256 + 6/1024).
        for (angle, expected) in [(1.925, 0.5), (1.7125, 1.0 - 0.103_515_625)] {
            assert!((turned(angle) - expected).abs() < 1e-5, "{angle} {}", turned(angle));
        }
    });
}

#[test]
fn hidden_and_mirrored_joints_are_at_rest_and_have_no_confidence() {
    let hide = |map: &Matrix3x4, by: [f32; 3]| {
        map.map(|[x, y, z, shift]| [by[0] * x, by[1] * y, by[2] * z, shift])
    };
    with_predictor(Predictor::Kernel, STRETCHING, |envelope| {
        let Stretched { rigid: pose, curves, .. } = stretched_pose(&envelope, &mut Rng(3), 0.2);
        let shown = features(&envelope, &pose, &curves);
        // A scale of 0, one axis of 0, a scale of 0.05, a mirror; joint 3 has no child.
        for by in [[0.0; 3], [1.0, 0.0, 1.0], [0.05; 3], [-1.0, 1.0, 1.0]] {
            let mut other = pose.clone();
            other[3] = hide(&pose[3], by);
            let found = features(&envelope, &other, &curves);
            assert_eq!(found[36..48], [0.0; 12]);
            assert_eq!(found[66..72], [0.0; 6], "the strain");
            assert_eq!((&found[..36], &found[48..66]), (&shown[..36], &shown[48..66]));
            assert_eq!(found[72..], shown[72..], "the curves");
            let (palette, confidence) = palette_with(&envelope, &other, &curves);
            assert_eq!((palette[3], confidence), (other[3], 0.0));
            assert!(flat(&palette).iter().all(|x| x.is_finite()));
            let mut joints = vec![f32::NAN; 4];
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            envelope.joint_confidences(&other, &curves, &mut scratch, &mut joints).unwrap();
            assert_eq!(joints[3], 0.0);
            assert!(joints[..3].iter().all(|confidence| *confidence > 0.0), "{joints:?}");
        }
        // A child of a hidden joint is at rest too, and the root may be hidden.
        for joint in 0..4 {
            let mut other = pose.clone();
            other[joint] = hide(&pose[joint], [0.0; 3]);
            let found = features(&envelope, &other, &curves);
            for child in (0..4).filter(|child| envelope.parent(*child) == Some(joint)) {
                assert_eq!(found[12 * child..][..12], [0.0; 12]);
            }
            assert_eq!(palette_with(&envelope, &other, &curves).1, 0.0);
        }
    });
    // A rigid model hides joints too.
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let mut pose = random_pose(&envelope, &mut Rng(3), 0.2);
        pose[3] = hide(&pose[3], [0.0; 3]);
        assert_eq!(features(&envelope, &pose, &[])[36..48], [0.0; 12]);
        assert_eq!(confident_palette(&envelope, &pose).1, 0.0);
    });
}

#[test]
fn a_joint_that_never_stretched_keeps_its_linear_part() {
    // Joints 0 and 3 have a stretch range of 0. A stretch along x and y leaves the rotation I.
    let map = [[1.5, 0.25, 0.0, 7.0], [0.25, 0.75, 0.0, 7.0], [0.0, 0.0, 1.0, 7.0]];
    let linear = [[1.5, 0.25, 0.0], [0.25, 0.75, 0.0], [0.0, 0.0, 1.0]];
    for predictor in Predictor::ALL {
        with_predictor(predictor, STRETCHING, |envelope| {
            let mut turns = vec![[[f32::NAN; 3]; 3]; 4];
            let mut strains = vec![[f32::NAN; 6]; 4];
            stages::polar(&envelope, &[map; 4], &mut turns, &mut strains).unwrap();
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for (joint, turn) in turns.iter().enumerate() {
                let expected = if joint % 3 == 0 { linear } else { identity };
                let off = max_difference(turn.as_flattened(), expected.as_flattened());
                assert!(off < 1e-6 && (off == 0.0 || joint % 3 > 0), "{joint}: {off}");
            }
            // Every product is exact; xx is half of 1.5² + 0.25² - 1.
            assert_eq!(strains, [[0.656_25, 0.281_25, 0.0, -0.187_5, 0.0, 0.0]; 4]);
        });
    }
}

#[test]
fn a_curve_outside_its_range_lowers_the_confidence() {
    let shape = Shape { joints: 0, curves: 4, ..SMALL };
    let mut pieces = Pieces::sample(Predictor::Kernel, shape);
    // Curve 0 is the only input, so curve 3 is known by its range alone.
    let mut groups = sample_groups(shape);
    for group in &mut groups {
        group.inputs.iter_mut().for_each(|input| input.0 = 0);
    }
    pieces.set_groups(&groups);
    let confidence = |least: f32, most: f32, value: f32| {
        let mut pieces = pieces.clone();
        for (at, end) in [least, most].into_iter().enumerate() {
            pieces.set_float(SectionKind::CurveRanges, 6 + at, end);
        }
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let (palette, confidence) = palette_with(&envelope, &[], &[0.0, 0.0, 0.25, value]);
        assert_eq!(palette, vec![IDENTITY; 3], "it moves nothing");
        confidence
    };
    // The distance from the middle against 1.5 times half of the range; 0 from 2 times and 0.1 on.
    for value in [-0.2499, 0.0, 0.5, 1.0, 1.2499] {
        assert_eq!(confidence(0.0, 1.0, value), 1.0, "{value}");
    }
    for value in [-0.61, 1.61, 100.0, -1e30] {
        assert_eq!(confidence(0.0, 1.0, value), 0.0, "{value}");
    }
    // Half of the way from 1.25 to 1.6.
    for value in [1.425, -0.425] {
        assert!((confidence(0.0, 1.0, value) - 0.5).abs() < 1e-5);
    }
    // A curve that never moved has no range: only 0.1 is left.
    assert_eq!([0.0, 0.11, -0.11].map(|value| confidence(0.0, 0.0, value)), [1.0, 0.0, 0.0]);
    assert!((confidence(0.0, 0.0, -0.05) - 0.5).abs() < 1e-5);
}

#[test]
fn a_joint_stretched_beyond_its_range_lowers_the_confidence() {
    // Joint 2 has a stretch range of 0.5, joint 3 of 0.
    for predictor in Predictor::ALL {
        with_predictor(predictor, Shape { curves: 0, ..STRETCHING }, |envelope| {
            let confidence = |joint: usize, strain: f32| {
                // A stretch along x whose strain is `strain`.
                let mut pose = vec![IDENTITY; 4];
                pose[joint][0][0] = (2.0 * strain + 1.0).sqrt();
                // The scale moves the joint's origin, so that its parent carries it.
                let origin = [2.0, 0.0, 1.0, 3.0][joint];
                pose[joint][0][3] = origin * (1.0 - pose[joint][0][0]);
                confident_palette(&envelope, &pose).1
            };
            let of_rotational = predictor == Predictor::Rotational;
            for (joint, range, most) in [(2, 0.5f32, 0.75f32), (3, 0.0, 0.0)] {
                let end = most + 0.5 * range + 0.1;
                let within = confidence(joint, most - 1e-4 * range);
                assert!(!of_rotational || within == 1.0);
                assert_eq!(confidence(joint, end + 1e-3), 0.0, "{joint}");
                let half = confidence(joint, 0.5 * (most + end));
                assert!((half - 0.5).abs() < 1e-3 || !of_rotational && half < 0.5, "{half}");
                assert!(half > 0.0);
            }
        });
    }
}
