//! Poses with results known without a reference: rest, one motion for all joints, degenerate
//! transforms.

use crate::common::{
    IDENTITY, call_error, max_difference, palette, rest, skinned, with_envelope, with_skin,
};
use models::{Rng, SMALL};
use sinew_runtime::{Argument, CallError, CallErrorKind, LocalTransform, model_space_pose};

#[test]
fn rest_pose_gives_rest_mesh() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        // Dyadic coefficients make the sums exact.
        assert_eq!(palette, vec![IDENTITY; envelope.palette_len()]);
        let (skinned, rest) = (skinned(skin, &palette), rest(skin));
        let positions = 3 * skin.vertex_len();
        assert_eq!(skinned[..positions], rest[..positions]);
        assert!(max_difference(&skinned, &rest) < 2e-7);
    });
}

#[test]
fn global_motion_passes_through() {
    with_envelope(SMALL, |envelope| {
        let mut rng = Rng(3);
        let mut local = (0..envelope.joint_len()).map(|_| rng.local(0.5)).collect::<Vec<_>>();
        let mut pose = vec![IDENTITY; envelope.joint_len()];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let still = palette(&envelope, &pose);
        // Rotate the root's frame by half a turn about z, then shift it.
        let [x, y, z, w] = local[envelope.root()].rotation;
        local[envelope.root()].rotation = [-y, x, w, -z];
        let [tx, ty, tz] = local[envelope.root()].translation;
        local[envelope.root()].translation = [4.0 - tx, 8.0 - ty, tz];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let moved = palette(&envelope, &pose);
        let expected = still.iter().map(|[x, y, z]| {
            let mut turned = [x.map(|a| -a), y.map(|a| -a), *z];
            turned[0][3] += 4.0;
            turned[1][3] += 8.0;
            turned
        });
        let expected = expected.collect::<Vec<_>>();
        let difference = max_difference(
            moved.as_flattened().as_flattened(),
            expected.as_flattened().as_flattened(),
        );
        assert!(difference < 5e-6, "{difference}");
        // Control: the comparator reports a difference.
        assert!(max_difference(moved[0].as_flattened(), still[0].as_flattened()) > 1.0);
    });
}

#[test]
fn local_transforms_give_the_rest_pose_back() {
    with_envelope(SMALL, |envelope| {
        let j = envelope.joint_len();
        let mut local =
            vec![
                LocalTransform { rotation: [0.0, 0.0, 0.0, 3.0], translation: [1.0, 0.0, 0.0] };
                j
            ];
        local[envelope.root()].translation = [0.0; 3];
        let mut pose = vec![[[f32::NAN; 4]; 3]; j];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        assert_eq!(pose, vec![IDENTITY; j]);

        let mut refused = |edit: &dyn Fn(&mut LocalTransform)| {
            let mut local = local.clone();
            edit(&mut local[2]);
            let error = model_space_pose(&envelope, &local, &mut pose).unwrap_err();
            assert_eq!(pose, vec![IDENTITY; j]);
            error
        };
        let error = |kind| CallError { index: 2, ..call_error(kind, Argument::Local) };
        let zero = error(CallErrorKind::ZeroRotation);
        assert_eq!(refused(&|local| local.rotation = [0.0; 4]), zero);
        assert_eq!(refused(&|local| local.rotation = [1e30; 4]), zero);
        let not_finite = error(CallErrorKind::NonFinite);
        assert_eq!(refused(&|local| local.rotation[3] = f32::NAN), not_finite);
        assert_eq!(refused(&|local| local.translation[0] = f32::INFINITY), not_finite);
        assert!(model_space_pose(&envelope, &local[1..], &mut pose).is_err());
    });
}

#[test]
fn degenerate_transforms_give_finite_results() {
    with_skin(SMALL, |envelope, skin| {
        let v = skin.vertex_len();
        let zero = vec![[[0.0; 4]; 3]; envelope.palette_len()];
        let out = skinned(skin, &zero);
        assert_eq!(out[..3 * v], vec![0.0; 3 * v]);
        assert_eq!(out[3 * v..], rest(skin)[3 * v..]);
        for scale in [1e-30, 1e-12, 1e12, 1e25] {
            let scaled = IDENTITY.map(|row| row.map(|x| x * scale));
            let out = skinned(skin, &vec![scaled; envelope.palette_len()]);
            assert!(out.iter().all(|x| x.is_finite()), "{scale}");
        }
        // Flat, mirrored, zero and half-turned poses.
        let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]];
        let mirrored = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let half = [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for joint in 0..envelope.joint_len() {
            for transform in [flat, mirrored, half, [[0.0; 4]; 3]] {
                let mut pose = vec![IDENTITY; envelope.joint_len()];
                pose[joint] = transform;
                let out = skinned(skin, &palette(&envelope, &pose));
                assert!(out.iter().all(|x| x.is_finite()));
            }
        }
    });
}
