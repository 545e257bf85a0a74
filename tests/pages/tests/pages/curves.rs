//! "Your curves" and "Stretch": a muscle that a curve swells, and a hidden hand.

use crate::math::{curved_palette, diagonal, farthest, moved, palette, rest, skinned};
use crate::shown::{curves, skeleton};
use pages::arm;
use sinew_runtime::envelope::{PoseFaultKind, Predictor};
use sinew_runtime::{CallErrorKind, Envelope, Matrix3x4, Model, Skin};
use sinew_trainer::examples::Examples;

/// Height of the muscle at a curve of 1, and its radius, both in diagonals.
const MUSCLE: [f64; 2] = [0.03, 0.15];

/// Returns the arm with a muscle between elbow and shoulder that swells by a curve from 0 to 1.
fn flexing() -> Examples {
    let mut examples = arm::EXAMPLES.clone();
    let [height, radius] = MUSCLE.map(|x| x * examples.diagonal());
    let origin = |name: &str| {
        let joint = examples.skeleton.names.iter().position(|own| own == name).unwrap();
        examples.skeleton.rest[joint].map(|[.., shift]| shift)
    };
    let (shoulder, elbow) = (origin("upper_arm"), origin("forearm"));
    let swell = |x: &[f64; 3]| {
        let off = (0..3).map(|c| (x[c] - 0.5 * (shoulder[c] + elbow[c])).powi(2)).sum::<f64>();
        height * (-off / radius.powi(2)).exp()
    };
    let swells: Vec<f64> = examples.rest.iter().map(swell).collect();
    examples.curve_names = vec!["flex".to_owned()];
    examples.curves = (0..examples.frame_len()).map(|f| (7 * f % 10) as f64 / 9.0).collect();
    for frame in 0..examples.frame_len() {
        let (value, normals) = (examples.curves[frame], examples.posed_normals(frame));
        let own = examples.vertices.iter_mut().skip(frame * swells.len());
        for ((vertex, normal), swell) in own.zip(normals).zip(&swells) {
            (0..3).for_each(|c| vertex[c] += value * swell * normal[c]);
        }
    }
    examples
}

#[test]
fn a_curve_is_bound_by_name_and_given_in_the_unit_of_training() {
    let model = Model::from_bytes(arm::file(&flexing(), Predictor::Kernel)).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert_eq!((envelope.curve_len(), envelope.curve_range(0)), (1, Some([0.0, 1.0])));
    let map = curves::bind(&envelope, &["smile", "flex"]).unwrap();
    let mut flexed = [f32::NAN];
    curves::curves(&map, &[0.5, 1.0], &mut flexed);
    assert_eq!(flexed, [1.0]);
    let refused = curves::bind(&envelope, &["smile"]).unwrap_err();
    assert_eq!((refused.kind, refused.index), (CallErrorKind::NoCurve, 0));

    let pose = arm::pose(&arm::EXAMPLES, 35);
    let skin_at = |curves: &[f32]| skinned(&model, &curved_palette(&envelope, &pose, curves).0);
    let size = diagonal(&rest(&model.first::<Skin>().unwrap()));
    let height = farthest(&skin_at(&flexed), &skin_at(&[0.0]), size);
    let confidence = |curves: &[f32]| curved_palette(&envelope, &pose, curves).1;
    println!("curves: swells by {height:.4}, confidence {:.3}", confidence(&flexed));
    let expected = MUSCLE[0] as f32;
    assert!((0.5 * expected..1.5 * expected).contains(&height), "{height}");

    // In percent.
    assert_eq!(envelope.check_pose(&pose, &flexed), Ok(()));
    let fault = envelope.check_pose(&pose, &[100.0]).unwrap_err();
    assert_eq!((fault.kind, fault.joint), (PoseFaultKind::Curve, 0));
    assert!(confidence(&flexed) > 0.5 && confidence(&[100.0]) == 0.0);
    skeleton::check(&envelope, &pose, &flexed);
}

#[test]
fn a_hidden_hand_shrinks_to_its_joint() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let hand = (0..envelope.joint_len()).find(|&j| envelope.joint_name(j) == Some("hand")).unwrap();
    let mut pose = arm::pose(&arm::EXAMPLES, 35);
    let [x, y, z] = moved(&pose[hand], envelope.rest_frame(hand).unwrap().map(|row| row[3]));
    let hidden: Matrix3x4 = [[0.0, 0.0, 0.0, x], [0.0, 0.0, 0.0, y], [0.0, 0.0, 0.0, z]];
    pose[hand] = hidden;
    let fault = envelope.check_pose(&pose, &[]).unwrap_err();
    assert_eq!((fault.kind, fault.joint), (PoseFaultKind::Hidden, hand));

    let (found, confidence) = palette(&envelope, &pose);
    assert_eq!((found[hand], confidence), (hidden, 0.0));
    let of_hand = envelope.groups().filter(|group| group.joint == hand);
    for helper in of_hand.flat_map(|group| group.proxies) {
        assert_eq!(found[envelope.joint_len() + helper], hidden);
    }
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut confidences = vec![f32::NAN; envelope.joint_len()];
    envelope.joint_confidences(&pose, &[], &mut scratch, &mut confidences).unwrap();
    for (joint, confidence) in confidences.into_iter().enumerate() {
        assert!((confidence == 0.0) == (joint == hand), "{joint}: {confidence}");
    }
}
