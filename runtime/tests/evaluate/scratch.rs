//! Batches and workspaces: the bits do not depend on the scratch.

use crate::common::{
    IDENTITY, bits, confident_palette, random_pose, with_envelope, with_predictor,
};
use models::{Rng, SMALL};
use sinew_runtime::envelope::{Predictor, scratch_len};
use sinew_runtime::{Matrix3x4, Workspace};

#[test]
fn a_batch_has_the_bits_of_single_poses() {
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let mut rng = Rng(17);
            let turns = [0.0, 0.05, 0.2, 1.0, 8.0];
            let poses = turns.map(|turn| random_pose(&envelope, &mut rng, turn));
            let alone = poses.each_ref().map(|pose| confident_palette(&envelope, pose));
            let expected = alone.each_ref().map(|(palette, _)| palette.as_slice()).concat();
            let mut out = vec![[[f32::NAN; 4]; 3]; expected.len()];
            let mut confidences = [f32::NAN; 5];
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let poses = poses.concat();
            envelope.palettes(&poses, &mut scratch, &mut out, &mut confidences).unwrap();
            let flat = |palettes: &[Matrix3x4]| bits(palettes.as_flattened().as_flattened());
            assert_eq!(flat(&out), flat(&expected));
            assert_eq!(bits(&confidences), bits(&alone.each_ref().map(|(_, found)| *found)));
            // The poses differ from each other.
            let first = envelope.palette_len();
            assert_ne!(out[..first], out[first..2 * first]);
            assert_eq!(envelope.palettes(&[], &mut scratch, &mut [], &mut []), Ok(()));
        });
    }
}

#[test]
fn a_workspace_on_the_stack_serves() {
    const LEN: usize = scratch_len(4, 3, 0);
    with_envelope(SMALL, |envelope| {
        assert_eq!(envelope.scratch_len(), LEN);
        let pose = vec![IDENTITY; envelope.joint_len()];
        let mut out = vec![IDENTITY; envelope.palette_len()];
        envelope.palette(&pose, &mut Workspace::<LEN>::new(), &mut out).unwrap();
    });
}

#[test]
fn base_and_correction_share_scratch() {
    // The greater of 12 J + 3 J + 9 P and of 12 J and the correction's scratch.
    assert_eq!(scratch_len(4, 3, 0), 87);
    assert_eq!(scratch_len(4, 3, 39), 87);
    assert_eq!(scratch_len(4, 3, 40), 88);
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let correction = if predictor.corrects() { 56 } else { 0 };
            assert_eq!(envelope.correction_len(), correction);
            assert_eq!(envelope.scratch_len(), scratch_len(4, 3, correction));
            // The previous content does not matter.
            let pose = random_pose(&envelope, &mut Rng(9), 0.2);
            let palettes = [0.0, f32::NAN, -3.0].map(|content| {
                let mut scratch = vec![content; envelope.scratch_len()];
                let mut out = vec![[[content; 4]; 3]; envelope.palette_len()];
                envelope.palette(&pose, &mut scratch, &mut out).unwrap();
                out
            });
            assert!(palettes[0] == palettes[1] && palettes[1] == palettes[2]);
        });
    }
}
