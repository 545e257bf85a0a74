//! Palettes and confidences of poses: scaled actors, joints outside their trained range, and the base.

use super::{each, posed, still, turned};
use models::{GOLDEN, Pieces};
use sinew_runtime::envelope::{LocalTransform, PoseFaultKind as Kind, Predictor};
use sinew_runtime::format::SectionKind;
use sinew_runtime::skin::Output;
use sinew_runtime::{
    Argument, CallErrorKind, Envelope, Matrix3x4, Model, Skin, SkinJob, matrix, scale_palette,
    take_scale,
};

#[test]
fn a_scaled_actor_is_the_scaled_skin() {
    for file in GOLDEN {
        let model = Model::from_bytes(file).unwrap();
        let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
        let evaluate = |mut pose: Vec<Matrix3x4>| {
            let scale = take_scale(&mut pose);
            let mut palette = vec![matrix::IDENTITY; envelope.palette_len()];
            let mut scratch = vec![0.0; envelope.scratch_len()];
            envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap();
            scale_palette(&mut palette, scale);
            let mut out = vec![0.0; 6 * skin.vertex_len()];
            let [positions, normals] = Output::interleaved(&mut out, 6, [0, 3]);
            SkinJob::new(skin, &palette).positions(positions).normals(normals).run().unwrap();
            (scale, out)
        };
        let pose = posed(&envelope, &turned(&envelope, 0.5));
        let (_, own) = evaluate(pose.clone());
        for factor in [0.5, 2.0, 1.1] {
            let mut scaled = pose.clone();
            scale_palette(&mut scaled, factor);
            assert_eq!(envelope.check_pose(&scaled, &[]).unwrap_err().kind, Kind::Scaled);
            let (scale, found) = evaluate(scaled);
            assert!((scale / factor - 1.0).abs() < 1e-6, "{scale}");
            let positions = found.chunks(6).zip(own.chunks(6));
            let same = |(a, b): (&[f32], &[f32])| a[0] == factor * b[0] && a[2] == factor * b[2];
            assert!(factor == 1.1 || positions.clone().all(same), "{factor} is a power of two");
            let (found, own) = (found.as_chunks::<6>().0, own.as_chunks::<6>().0);
            for (found, own) in found.iter().zip(own) {
                for axis in 0..3 {
                    let expected = factor * own[axis];
                    assert!((found[axis] - expected).abs() < 1e-5 * factor, "{factor}");
                    assert!((found[axis + 3] - own[axis + 3]).abs() < 1e-5, "{factor}");
                }
            }
        }
    }
}

#[test]
fn joint_confidences_follow_the_groups_of_their_maps() {
    each(|envelope| {
        let pose = posed(envelope, &turned(envelope, 0.25));
        let mut scratch = vec![0.0; envelope.scratch_len()];
        let mut found = vec![f32::NAN; pose.len()];
        let curves = still(envelope);
        let done = envelope.joint_confidences(&pose, &curves, &mut scratch, &mut found);
        if !envelope.predictor().corrects() {
            assert_eq!(done.unwrap_err().kind, CallErrorKind::NoStage);
            return;
        }
        done.unwrap();
        let moved = |joint: usize| {
            envelope.groups().any(|group| group.joint == joint && group.centre_len() > 0)
        };
        for (joint, &confidence) in found.iter().enumerate() {
            assert!(confidence == 1.0 || moved(joint) && (0.0..1.0).contains(&confidence));
        }
        // Uncertainties add up.
        let mut palette = vec![matrix::IDENTITY; envelope.palette_len()];
        let all = envelope.palette(&pose, &curves, &mut scratch, &mut palette).unwrap();
        assert_eq!(all < 1.0, found.iter().any(|confidence| *confidence < 1.0));
        let short = envelope.joint_confidences(&pose, &curves, &mut scratch, &mut found[1..]);
        assert_eq!(short.unwrap_err().argument, Argument::Confidences);
    });
}

#[test]
fn a_joint_outside_its_trained_range_lowers_the_confidence_with_or_without_maps() {
    let mut pieces = Pieces::small(Predictor::Kernel);
    // The confidence of a pose that rotates one joint with this range, the joints' confidences, and
    // the palette.
    let mut turned_by = |angle: f32, joint: usize, range: f32| {
        pieces.set_float(SectionKind::PoseRanges, joint, range);
        let bytes = pieces.bytes();
        let model = Model::from_bytes(&bytes).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let mut local: Vec<LocalTransform> = envelope.rest_locals().collect();
        local[joint] = turned(&envelope, angle / (1.0 + joint as f32))[joint];
        let pose = posed(&envelope, &local);
        let mut scratch = vec![0.0; envelope.scratch_len()];
        let mut palette = vec![matrix::IDENTITY; envelope.palette_len()];
        let mut joints = vec![f32::NAN; pose.len()];
        envelope.joint_confidences(&pose, &[], &mut scratch, &mut joints).unwrap();
        (envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap(), joints[joint], palette)
    };
    let mut doubted = 0;
    let cases = [(0.0, 0.0), (0.0, 0.04), (0.5, 0.7), (0.5, 0.9), (0.5, 1.4), (1.6, 2.9)];
    // Joint 1 is the root.
    for (joint, (range, angle)) in [0, 2, 3].into_iter().flat_map(|j| cases.map(|case| (j, case))) {
        let loose = turned_by(angle, joint, 3.0);
        let found = turned_by(angle, joint, range);
        let excess = 4.0 * (angle / 4.0).sin() - 1.5 * range;
        let u = (excess / (0.5 * range + 0.1)).clamp(0.0, 1.0);
        let known = 1.0 - u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        assert!((found.0 - loose.0.min(known)).abs() < 1e-5, "{joint} {range} {angle}");
        assert!((found.1 - loose.1.min(known)).abs() < 1e-5, "{joint} {range} {angle}");
        assert_eq!(found.2, loose.2, "it moves nothing");
        doubted += usize::from(known < loose.0);
    }
    assert!(doubted >= 6, "{doubted} poses of which the maps are surer");
}

#[test]
fn the_base_is_the_palette_without_its_correction() {
    each(|envelope| {
        let pose = posed(envelope, &turned(envelope, 0.25));
        let (curves, mut scratch) = (still(envelope), vec![0.0; envelope.scratch_len()]);
        let palette = vec![matrix::IDENTITY; envelope.palette_len()];
        let (mut whole, mut base) = (palette.clone(), palette);
        let found = envelope.palette(&pose, &curves, &mut scratch, &mut whole).unwrap();
        let confidence = envelope.base_palette(&pose, &curves, &mut scratch, &mut base).unwrap();
        if envelope.predictor().reconstructs() {
            assert_eq!((base, confidence), (whole, found));
        } else {
            assert_ne!(base, whole);
            assert_eq!((&base[..pose.len()], confidence), (&*pose, 1.0));
            for group in envelope.groups() {
                for helper in &base[pose.len()..][group.proxies.clone()] {
                    assert_eq!(*helper, pose[group.joint]);
                }
            }
        }
        let refused = envelope.base_palette(&pose, &curves, &mut [], &mut []);
        assert_eq!(refused.unwrap_err().argument, Argument::Palette);
    });
}
