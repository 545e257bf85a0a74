//! "Your skeleton", "Scale", "Levels of detail": poses of an engine's skeleton.

use crate::math::{diagonal, farthest, palette, product, rest, skinned};
use crate::shown::axes::TO_ENGINE;
use crate::shown::{scale, seen, skeleton};
use pages::arm;
use sinew_runtime::envelope::{FOLDED, PoseFaultKind, Predictor};
use sinew_runtime::{CallErrorKind, Matrix3x4, Model};

/// Where the engine's actor stands, and the inverse of that.
const ACTOR: Matrix3x4 = [[0.0, -1.0, 0.0, 3.0], [1.0, 0.0, 0.0, -2.0], [0.0, 0.0, 1.0, 1.0]];
const TO_MODEL: Matrix3x4 = [[0.0, 1.0, 0.0, 2.0], [-1.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1.0, -1.0]];

/// How far off the arm is that is scaled by 1.1, by predictor, as the page says.
const SCALED: [(Predictor, f32); 2] =
    [(Predictor::Kernel, 0.00079), (Predictor::Rotational, 0.414)];

#[test]
fn frames_of_a_larger_skeleton_are_gathered_by_name() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.envelope().unwrap();
    let expected = arm::pose(&arm::EXAMPLES, 35);
    // Backwards, with a root of the world, and a sword in between.
    let mut names = vec!["world", "sword"];
    let mut world = vec![[[7.0; 4]; 3]; 2];
    for joint in (0..envelope.joint_len()).rev() {
        names.push(envelope.joint_name(joint).unwrap());
        let frame = product(&expected[joint], &envelope.rest_frame(joint).unwrap());
        world.push(product(&ACTOR, &frame));
    }
    let map = skeleton::bind(&envelope, &names).unwrap();
    let mut pose = vec![Matrix3x4::default(); envelope.joint_len()];
    skeleton::pose(&envelope, &map, &world, &TO_MODEL, &mut pose).unwrap();
    let size = diagonal(&rest(&model.skin().unwrap()));
    let skin_of = |pose: &[Matrix3x4]| skinned(&model, &palette(&envelope, pose).0);
    let off = farthest(&skin_of(&pose), &skin_of(&expected), size);
    println!("skeleton: {off:.1e} of the diagonal");
    assert!(off < 1e-5);
    // A skeleton without the twist of the forearm: it follows its parent.
    let twist = names.iter().position(|name| *name == "forearm_twist").unwrap();
    names[twist] = "spare";
    let map = skeleton::bind(&envelope, &names).unwrap();
    let folded = map.iter().position(|place| *place == FOLDED).unwrap();
    skeleton::pose(&envelope, &map, &world, &TO_MODEL, &mut pose).unwrap();
    assert_eq!(pose[folded], pose[envelope.parent(folded).unwrap()]);
    // What an engine does wrong first is told apart.
    let fault = |pose: &[Matrix3x4]| envelope.check_pose(pose).unwrap_err().kind;
    assert!(envelope.check_pose(&expected).is_ok());
    let mut converted = arm::EXAMPLES.clone();
    converted.convert_to(&sinew_runtime::format::Space::UNREAL).unwrap();
    assert_eq!(fault(&arm::pose(&converted, 35)), PoseFaultKind::Handedness);
    let mirrored: Vec<_> = expected.iter().map(|matrix| product(&TO_ENGINE, matrix)).collect();
    assert_eq!(fault(&mirrored), PoseFaultKind::Mirrored);
    let frames: Vec<_> = (0..pose.len()).map(|joint| world[pose.len() + 1 - joint]).collect();
    assert_eq!(fault(&frames), PoseFaultKind::Frames);
    assert_eq!(fault(&vec![[[0.0; 4]; 3]; pose.len()]), PoseFaultKind::Unset);
    // An importer's prefix, and a skeleton of another character.
    let prefixed: Vec<String> = names.iter().map(|name| format!("mixamorig:{name}")).collect();
    let prefixed: Vec<&str> = prefixed.iter().map(String::as_str).collect();
    let refused = skeleton::bind(&envelope, &prefixed).unwrap_err();
    assert_eq!(refused.kind, CallErrorKind::OtherName);
    let root = envelope.joint_name(envelope.root()).unwrap();
    let refused = skeleton::bind(&envelope, &[root, "sword"]).unwrap_err();
    assert_eq!(refused.kind, CallErrorKind::NoJoints);
}

#[test]
fn a_scaled_actor_is_wrong_and_certain_until_its_scale_is_taken_out() {
    for (predictor, said) in SCALED {
        let model = Model::from_bytes(arm::file(&arm::EXAMPLES, predictor)).unwrap();
        let envelope = model.envelope().unwrap();
        let pose = arm::pose(&arm::EXAMPLES, 35);
        let size = 1.1 * diagonal(&rest(&model.skin().unwrap()));
        let larger = |x: [f32; 3]| x.map(|x| 1.1 * x);
        let own = skinned(&model, &palette(&envelope, &pose).0);
        let expected: Vec<_> = own.into_iter().map(larger).collect();
        let mut scaled: Vec<_> = pose.iter().map(|m| m.map(|row| row.map(|x| 1.1 * x))).collect();
        let (wrong, confidence) = palette(&envelope, &scaled);
        let off = farthest(&skinned(&model, &wrong), &expected, size);
        let mut scratch = vec![0.0; envelope.scratch_len()];
        let mut right = vec![Matrix3x4::default(); envelope.palette_len()];
        scale::palette(&envelope, &mut scaled, &mut scratch, &mut right).unwrap();
        let left = farthest(&skinned(&model, &right), &expected, size);
        println!(
            "scale: {predictor:?} {off:.5} of the diagonal off, confidence {confidence:.3}; left {left:.1e}"
        );
        assert!((0.9 * said..1.1 * said).contains(&off) && confidence > 0.8 && left < 1e-5);
    }
}

#[test]
fn joints_alone_do_where_their_error_is_not_seen() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.envelope().unwrap();
    let pose = arm::pose(&arm::EXAMPLES, 35);
    let (full, _) = palette(&envelope, &pose);
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut found = vec![Matrix3x4::default(); envelope.palette_len()];
    let certificate = envelope.certificate();
    assert!(certificate.base_training_rms > 2.0 * certificate.training_rms);
    seen::palette_seen(&envelope, &pose, 0.0, &mut scratch, &mut found).unwrap();
    assert_eq!(found, full);
    let seen = 2.0 * certificate.base_training_rms;
    seen::palette_seen(&envelope, &pose, seen, &mut scratch, &mut found).unwrap();
    let off = farthest(&skinned(&model, &found), &skinned(&model, &full), certificate.diagonal);
    assert!(off > 0.0 && off < 0.2, "{off}");
}
