//! Poses that do not fit a skeleton, and the faults that name the mistake.

use super::{ACTOR, after, each, posed, sample, still, turned};
use models::{JOINTLESS, Pieces, SMALL, STRETCHING};
use sinew_runtime::envelope::{
    CURVE_MARGIN, PoseFault, PoseFaultKind as Kind, Predictor, RIGID_TOLERANCE, STRETCH_MARGIN,
};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Matrix3x4, Model, matrix};

#[test]
fn poses_are_taken_and_faults_named() {
    each(|envelope| {
        let pose = posed(envelope, &turned(envelope, 0.5));
        assert_eq!(envelope.check_pose(&pose, &still(envelope)), Ok(()));
        let last = pose.len() - 1;
        let changed = |change: &dyn Fn(&mut Matrix3x4)| {
            let mut pose = pose.clone();
            change(&mut pose[last]);
            envelope.check_pose(&pose, &still(envelope)).unwrap_err()
        };
        let fault = envelope.check_pose(&pose[1..], &still(envelope)).unwrap_err();
        assert_eq!((fault.kind, fault.joint), (Kind::Length, last));
        for value in [f32::NAN, f32::INFINITY] {
            for place in 0..12 {
                let fault = changed(&|m| m[place / 4][place % 4] = value);
                assert_eq!((fault.kind, fault.joint), (Kind::NonFinite, last));
            }
        }
        let fault = changed(&|m| m[1] = m[1].map(|x| -x));
        assert_eq!((fault.kind, fault.joint), (Kind::Mirrored, last));
        let fault = changed(&|m| m.as_flattened_mut().iter_mut().for_each(|x| *x *= 1.1));
        assert_eq!((fault.kind, fault.joint), (Kind::Scaled, last));
        assert!((fault.factor - 1.1).abs() < 1e-6 && (fault.found - 0.21).abs() < 1e-3);
        let fault = changed(&|m| m[2] = m[2].map(|x| 1.2 * x));
        assert_eq!((fault.kind, fault.joint), (Kind::Stretched, last));
        let slightly = 1.0 + 0.4 * RIGID_TOLERANCE;
        let mut nearly = pose.clone();
        nearly[last] =
            nearly[last].map(|[x, y, z, t]| [slightly * x, slightly * y, slightly * z, t]);
        // The scale also moves the joint's origin, by too little to show.
        let found = envelope.check_pose(&nearly, &still(envelope));
        assert!(!matches!(found, Err(PoseFault { kind: Kind::Scaled, .. })));
        if pose.len() > 1 {
            let fault = changed(&|m| m[0][3] += 50.0);
            assert_eq!((fault.kind, fault.joint), (Kind::Apart, last));
            assert!((fault.found - 50.0).abs() < 1.0, "{fault}");
        }
    });
    for kind in Kind::ALL {
        let fault =
            PoseFault { kind, joint: 3, factor: 10.0, found: 0.5, allowed: 0.1, axes: [1, -3, 2] };
        let text = fault.to_string();
        assert!(text.contains('3') && text.ends_with(kind.remedy()), "{text}");
    }
}

#[test]
fn matrices_of_another_space_are_named() {
    each(|envelope| {
        let pose = posed(envelope, &turned(envelope, 0.5));
        let frames: Vec<_> = pose
            .iter()
            .enumerate()
            .map(|(j, m)| after(m, &envelope.rest_frame(j).unwrap()))
            .collect();
        let binds: Vec<_> = envelope.inverse_binds().collect();
        let gathered = |frames: &[Matrix3x4]| -> Vec<Matrix3x4> {
            frames.iter().zip(&binds).map(|(frame, bind)| after(frame, bind)).collect()
        };
        let local = |joint: usize| match envelope.parent(joint) {
            Some(parent) => after(&inverse(&frames[parent]), &frames[joint]),
            None => frames[joint],
        };
        let local: Vec<_> = (0..pose.len()).map(local).collect();
        let check = |pose: &[Matrix3x4]| envelope.check_pose(pose, &still(envelope));
        let fault = |pose: &[Matrix3x4]| check(pose).map_err(|fault| fault.kind);
        let zero = vec![[[0.0; 4]; 3]; pose.len()];
        assert_eq!(fault(&zero), Err(Kind::Unset));
        let mut one = pose.clone();
        one[pose.len() - 1] = zero[0];
        assert_eq!(
            check(&one).unwrap_err(),
            PoseFault { joint: pose.len() - 1, ..check(&zero).unwrap_err() }
        );
        if pose.len() == 1 {
            return;
        }
        assert_eq!(fault(&gathered(&frames)), Ok(()));
        assert_eq!(fault(&frames), Err(Kind::Frames));
        assert_eq!(fault(&gathered(&pose)), Err(Kind::BoundTwice));
        assert_eq!(fault(&local), Err(Kind::Local));
        assert_eq!(fault(&gathered(&local)), Err(Kind::Local));
        let unset = vec![matrix::IDENTITY; pose.len()];
        assert_eq!((fault(&unset), fault(&gathered(&unset))), (Ok(()), Err(Kind::Unset)));
        // In another place of the world each mistake is the same.
        let there: Vec<_> = frames.iter().map(|frame| after(&ACTOR, frame)).collect();
        assert_eq!(fault(&there), Err(Kind::Frames));
    });
}

/// Inverts a rigid matrix.
fn inverse(m: &Matrix3x4) -> Matrix3x4 {
    std::array::from_fn(|r| {
        let row = |c: usize| m[c][r];
        [row(0), row(1), row(2), -(0..3).map(|c| row(c) * m[c][3]).sum::<f32>()]
    })
}

#[test]
fn a_joint_may_stretch_twice_as_far_as_in_training() {
    sample(STRETCHING, |envelope| {
        assert_eq!(
            [0, 1, 2, 3].map(|joint| envelope.stretch_range(joint)),
            [0.0, 0.25, 0.5, 0.0].map(Some)
        );
        // The joints lie along x: a stretch along y moves none of them.
        let stretched = |joint: usize, strain: f32| {
            let mut pose = vec![matrix::IDENTITY; 4];
            pose[joint][1][1] = (1.0 + 2.0 * strain).sqrt();
            envelope.check_pose(&pose, &[0.0; 3])
        };
        for (joint, range) in [(1, 0.25), (2, 0.5)] {
            let most = STRETCH_MARGIN * range;
            for strain in [0.0, range, 0.99 * most, -0.4] {
                assert_eq!(stretched(joint, strain), Ok(()), "{joint} {strain}");
            }
            let fault = stretched(joint, 1.01 * most).unwrap_err();
            assert_eq!((fault.kind, fault.joint, fault.allowed), (Kind::Stretched, joint, most));
            assert!((fault.found - 1.01 * most).abs() < 1e-5, "{fault}");
        }
        let fault = stretched(3, 0.01).unwrap_err();
        let found = (fault.kind, fault.joint, fault.allowed);
        assert_eq!(found, (Kind::Stretched, 3, RIGID_TOLERANCE));
        // A shear has a strain xy, which counts for yx too, and a strain yy.
        let mut pose = vec![matrix::IDENTITY; 4];
        pose[2][0][1] = 1.0;
        assert_eq!(envelope.check_pose(&pose, &[0.0; 3]), Ok(()));
        pose[2][0][1] = 1.2;
        let fault = envelope.check_pose(&pose, &[0.0; 3]).unwrap_err();
        assert_eq!((fault.kind, fault.joint), (Kind::Stretched, 2));
        // Strain xy is 0.6, yy is 0.72.
        assert!((fault.found - (0.72f32 * 0.72 + 2.0 * 0.36).sqrt()).abs() < 1e-5, "{fault}");
    });
}

#[test]
fn hidden_and_mirrored_joints_are_faults_of_their_own() {
    for shape in [SMALL, STRETCHING] {
        sample(shape, |envelope| {
            let curves = still(envelope);
            let fault = |joint: usize, by: [f32; 3], shift: f32| {
                let mut pose = vec![matrix::IDENTITY; 4];
                pose[joint] =
                    [[by[0], 0.0, 0.0, shift], [0.0, by[1], 0.0, 0.0], [0.0, 0.0, by[2], 0.0]];
                let fault = envelope.check_pose(&pose, &curves).unwrap_err();
                assert_eq!(fault.joint, joint);
                (fault.kind, fault.factor)
            };
            // At its origin, where engines collapse the skin of a hidden limb.
            for joint in [0, 2, 3] {
                let shift = [2.0, 0.0, 1.0, 3.0][joint];
                assert_eq!(fault(joint, [0.0; 3], shift), (Kind::Hidden, 0.0));
                let (kind, factor) = fault(joint, [0.005; 3], shift);
                assert!(kind == Kind::Hidden && (factor - 0.005).abs() < 1e-6, "{factor}");
                assert_eq!(fault(joint, [-1.0, 1.0, 1.0], 2.0 * shift).0, Kind::Mirrored);
            }
            // Nothing at all was written.
            assert_eq!(fault(1, [0.0; 3], 0.0).0, Kind::Unset);
        });
    }
}

#[test]
fn curves_in_another_unit_are_named() {
    sample(STRETCHING, |envelope| {
        let pose = vec![matrix::IDENTITY; 4];
        let check = |curves: &[f32]| envelope.check_pose(&pose, curves);
        // The ranges are 0 to 1, -0.5 to 0.5, and 0.25 to 2.
        for curves in [[0.0; 3], [1.0, 0.5, 2.0], [-10.0, 5.0, -20.0], [10.0, -5.0, 20.0]] {
            assert_eq!(check(&curves), Ok(()), "{curves:?}");
        }
        for (curve, value, most) in [(0, 50.0, 1.0), (0, 10.1, 1.0), (1, -5.1, 0.5), (2, 21.0, 2.0)]
        {
            let mut curves = [0.0; 3];
            curves[curve] = value;
            let expected = PoseFault {
                kind: Kind::Curve,
                joint: curve,
                factor: 1.0,
                found: value,
                allowed: CURVE_MARGIN * most,
                axes: [1, 2, 3],
            };
            assert_eq!(check(&curves), Err(expected));
        }
        let percent = check(&[100.0, 0.0, 0.0]).unwrap_err().to_string();
        assert!(percent.starts_with("pose: curve 0 is 100, expected at most 10"), "{percent}");
        assert!(percent.ends_with("a percentage must be divided by 100"), "{percent}");
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let fault = check(&[0.0, value, 0.0]).unwrap_err();
            assert_eq!((fault.kind, fault.joint), (Kind::Curve, 1));
        }
        for len in [0, 2, 4] {
            let fault = check(&vec![0.0; len]).unwrap_err();
            assert_eq!((fault.kind, fault.joint), (Kind::CurveLength, len));
        }
    });
    // A curve that training left at 0 has no scale, but must be finite.
    let mut pieces = Pieces::sample(Predictor::Kernel, JOINTLESS);
    pieces.section(SectionKind::CurveRanges).fill(0);
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert_eq!(envelope.check_pose(&[], &[1e9; 5]), Ok(()));
    let fault = envelope.check_pose(&[], &[0.0, 0.0, 0.0, 0.0, f32::NAN]).unwrap_err();
    assert_eq!((fault.kind, fault.joint), (Kind::Curve, 4));
}
