//! Palettes whose bits are known: at rest, far from training, and from the stages.

use super::{base, corrected, features, flat_bits};
use crate::common::{
    IDENTITY, Stretched, confident_palette, palette_with, random_pose, stage_error, stretched_pose,
    with_predictor,
};
use models::{JOINTLESS, Pieces, Rng, SMALL, STRETCHING, Shape, sample_groups};
use sinew_runtime::envelope::{GroupKernel, Predictor};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Matrix3x4, Model, stages};

#[test]
fn the_rest_pose_is_exact_bit_for_bit() {
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let rest = vec![IDENTITY; envelope.joint_len()];
        assert_eq!(features(&envelope, &rest, &[]), vec![0.0; 12 * rest.len()]);
        let (palette, confidence) = confident_palette(&envelope, &rest);
        let identity = vec![IDENTITY; envelope.palette_len()];
        assert_eq!(flat_bits(&palette), flat_bits(&identity));
        assert!(confidence > 0.0, "the maps have run");
    });
    // A value at rest that is off by a last place must matter. A Gaussian has no values at rest.
    let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
    let mut groups = sample_groups(SMALL);
    groups[0].kernel = GroupKernel::Matern52;
    pieces.set_groups(&groups);
    // 8 features and 8 weights, 2 blocks of 5 columns of centres, then the values at rest.
    let at = 8 + 8 + 8 * 2 * 5;
    let section = SectionKind::Corrections;
    let words = pieces.section(section).as_chunks::<4>().0;
    let rest = f32::from_le_bytes(words[at]);
    pieces.set_float(section, at, rest.next_up());
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let (palette, _) = confident_palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
    assert_ne!(palette, vec![IDENTITY; envelope.palette_len()]);
}

#[test]
fn far_poses_have_no_confidence_and_keep_their_base() {
    let groups = sample_groups(SMALL);
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        // Every joint far from its parent.
        let far = (0..4).map(|joint| {
            let mut map = IDENTITY;
            map[0][3] = [40.0, 0.0, 20.0, 60.0][joint];
            map[1][3] = [-0.0, 30.0, 60.0, 90.0][joint];
            map
        });
        let far = far.collect::<Vec<_>>();
        let kept = |pose: &[Matrix3x4]| {
            let base = base(&groups, pose);
            let (palette, confidence) = corrected(&envelope, pose, &[], &base);
            assert_eq!(flat_bits(&palette), flat_bits(&base));
            assert!(confidence < 1e-29, "{confidence}");
        };
        kept(&far);
        // So far that distances overflow: only the base is left.
        let mut lost = far.clone();
        lost[3][0] = [1e30, 0.0, 0.0, 1e30];
        lost[0][1] = [0.0, 3e38, 0.0, -3e38];
        kept(&lost);
    });
}

#[test]
fn features_that_are_nan_add_nothing() {
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let pose = vec![IDENTITY; 4];
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            let mut out = vec![IDENTITY; 7];
            let mut scratch = vec![f32::NAN; envelope.correction_len()];
            let phi = vec![value; 12 * 4];
            let confidence = stages::correction(&envelope, &pose, &phi, &mut scratch, &mut out);
            assert!(confidence.is_ok_and(|confidence| confidence < 1e-29), "{value}");
            assert_eq!(out, vec![IDENTITY; 7]);
        }
    });
}

#[test]
fn joints_are_copied_bit_for_bit() {
    let groups = sample_groups(SMALL);
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let mut pose = random_pose(&envelope, &mut Rng(2), 1.0);
        pose[2][1][1] = -0.0;
        let (palette, _) = confident_palette(&envelope, &pose);
        assert_eq!(flat_bits(&palette[..4]), flat_bits(&pose));
        assert_ne!(palette[4], pose[groups[0].joint], "the helpers are moved");
        let mut joints_only = vec![[[f32::NAN; 4]; 3]; 7];
        stages::joints(&envelope, &pose, &mut joints_only).unwrap();
        assert_eq!(flat_bits(&joints_only), flat_bits(&base(&groups, &pose)));
    });
    // Without helpers the envelope is linear blend skinning, with confidence 1.
    with_predictor(Predictor::Kernel, Shape { proxies: 0, ..SMALL }, |envelope| {
        let pose = random_pose(&envelope, &mut Rng(2), 1.0);
        assert_eq!(confident_palette(&envelope, &pose), (pose, 1.0));
    });
}

#[test]
fn whole_palettes_are_their_stages() {
    for shape in [SMALL, STRETCHING, JOINTLESS] {
        let groups = sample_groups(shape);
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let Stretched { pose, curves, .. } = stretched_pose(&envelope, &mut Rng(6), 0.2);
            let (whole, confidence) = palette_with(&envelope, &pose, &curves);
            let base = base(&groups, &pose);
            let (parts, of_parts) = corrected(&envelope, &pose, &curves, &base);
            assert_eq!((flat_bits(&whole), confidence), (flat_bits(&parts), of_parts));
            assert!(confidence > 0.0 || shape.curves > 0);
            assert_ne!(whole, base);
        });
    }
}

#[test]
fn only_rotational_models_have_a_palette_without_kernel_maps() {
    let each = Predictor::ALL.into_iter().flat_map(|each| [SMALL, STRETCHING].map(|s| (each, s)));
    for (predictor, shape) in each {
        with_predictor(predictor, shape, |envelope| {
            let Stretched { pose, .. } = stretched_pose(&envelope, &mut Rng(6), 2.0);
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let mut out = vec![IDENTITY; envelope.palette_len()];
            let confidence = envelope.rotational_palette(&pose, &mut scratch, &mut out);
            if predictor == Predictor::Rotational {
                let (whole, expected) = confident_palette(&envelope, &pose);
                assert_eq!((flat_bits(&out), confidence), (flat_bits(&whole), Ok(expected)));
            } else {
                assert_eq!(confidence, Err(stage_error(predictor)));
                assert!(out.iter().all(|map| *map == IDENTITY));
            }
        });
    }
}
