//! An engine's character: "Your mesh", "Your skeleton", "Scale", "Levels of detail", "Far from the
//! origin".

use crate::math::{diagonal, farthest, palette, product, rest, skinned};
use crate::shown::axes::TO_ENGINE;
use crate::shown::place::place;
use crate::shown::{bones, mesh, scale, seen, skeleton, vertices};
use pages::arm;
use sinew_runtime::envelope::{FOLDED, PoseFaultKind, Predictor, Trs};
use sinew_runtime::{CallErrorKind, Envelope, Matrix3x4, Model, Skin};

#[test]
fn a_mesh_in_another_order_is_matched_and_skinned() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    let v = skin.vertex_len();
    // In reverse order, with every third vertex twice.
    let own: Vec<usize> =
        (0..v).rev().flat_map(|v| [v; 2].into_iter().take(1 + usize::from(v % 3 == 0))).collect();
    let vertex = |&v: &usize| (skin.rest_position(v).unwrap(), skin.rest_normal(v).unwrap());
    let all: Vec<_> = own.iter().map(vertex).collect();
    let size = diagonal(&rest(&skin));
    let (remap, off) = mesh::remap(&skin, &all, size / 1000.0);
    assert!(off == 0.0);
    let (palette, _) = palette(&model.first::<Envelope>().unwrap(), &arm::pose(&arm::EXAMPLES, 35));
    let mut buffer = vec![7.0; 8 * own.len()];
    vertices::skin_mesh(skin, &palette, &remap, &mut buffer).unwrap();
    let expected = skinned(&model, &palette);
    let expected: Vec<_> = own.iter().map(|&v| expected[v]).collect();
    let found: Vec<_> =
        buffer.chunks_exact(8).map(|vertex| [vertex[0], vertex[1], vertex[2]]).collect();
    assert!(farthest(&found, &expected, size) < 1e-6);
    assert!(
        buffer.chunks_exact(8).all(|vertex| vertex[6..] == [7.0; 2]),
        "texture coordinates stay"
    );
    // In centimetres, it is a different mesh.
    let other: Vec<_> = all.iter().map(|(x, n)| (x.map(|x| 100.0 * x), *n)).collect();
    assert!(mesh::remap(&skin, &other, size / 1000.0).1 > size);
}

/// Transform of the engine's actor, and its inverse.
const ACTOR: Matrix3x4 = [[0.0, -1.0, 0.0, 3.0], [1.0, 0.0, 0.0, -2.0], [0.0, 0.0, 1.0, 1.0]];
const TO_MODEL: Matrix3x4 = [[0.0, 1.0, 0.0, 2.0], [-1.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1.0, -1.0]];

/// Error of the arm scaled by 1.1, by predictor: the figures of the page.
const SCALED: [(Predictor, f32); 2] =
    [(Predictor::Kernel, 0.00079), (Predictor::Rotational, 0.414)];

#[test]
fn frames_of_a_larger_skeleton_are_gathered_by_name() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let expected = arm::pose(&arm::EXAMPLES, 35);
    // In reverse order, with a root of the world and a sword in between.
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
    let size = diagonal(&rest(&model.first::<Skin>().unwrap()));
    let skin_of = |pose: &[Matrix3x4]| skinned(&model, &palette(&envelope, pose).0);
    let off = farthest(&skin_of(&pose), &skin_of(&expected), size);
    println!("skeleton: {off:.1e} of the diagonal");
    assert!(off < 1e-5);
    // A skeleton without the forearm's twist joint: the joint follows its parent.
    let twist = names.iter().position(|name| *name == "forearm_twist").unwrap();
    names[twist] = "spare";
    let map = skeleton::bind(&envelope, &names).unwrap();
    let folded = map.iter().position(|place| *place == FOLDED).unwrap();
    skeleton::pose(&envelope, &map, &world, &TO_MODEL, &mut pose).unwrap();
    assert_eq!(pose[folded], pose[envelope.parent(folded).unwrap()]);
    // Distinguishes the most common faults of engines.
    let fault = |pose: &[Matrix3x4]| envelope.check_pose(pose, &[]).unwrap_err().kind;
    assert!(envelope.check_pose(&expected, &[]).is_ok());
    let mut converted = arm::EXAMPLES.clone();
    converted.convert_to(&sinew_runtime::format::Space::UNREAL).unwrap();
    assert_eq!(fault(&arm::pose(&converted, 35)), PoseFaultKind::Handedness);
    let mirrored: Vec<_> = expected.iter().map(|matrix| product(&TO_ENGINE, matrix)).collect();
    assert_eq!(fault(&mirrored), PoseFaultKind::Mirrored);
    let frames: Vec<_> = (0..pose.len()).map(|joint| world[pose.len() + 1 - joint]).collect();
    assert_eq!(fault(&frames), PoseFaultKind::Frames);
    assert_eq!(fault(&vec![[[0.0; 4]; 3]; pose.len()]), PoseFaultKind::Unset);
    // An importer's prefix, and the skeleton of another character.
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
        let envelope = model.first::<Envelope>().unwrap();
        let pose = arm::pose(&arm::EXAMPLES, 35);
        let size = 1.1 * diagonal(&rest(&model.first::<Skin>().unwrap()));
        let larger = |x: [f32; 3]| x.map(|x| 1.1 * x);
        let own = skinned(&model, &palette(&envelope, &pose).0);
        let expected: Vec<_> = own.into_iter().map(larger).collect();
        let mut scaled: Vec<_> = pose.iter().map(|m| m.map(|row| row.map(|x| 1.1 * x))).collect();
        let (wrong, confidence) = palette(&envelope, &scaled);
        let off = farthest(&skinned(&model, &wrong), &expected, size);
        let mut scratch = vec![0.0; envelope.scratch_len()];
        let mut right = vec![Matrix3x4::default(); envelope.palette_len()];
        scale::palette(&envelope, &mut scaled, &[], &mut scratch, &mut right).unwrap();
        let left = farthest(&skinned(&model, &right), &expected, size);
        println!(
            "scale: {predictor:?} {off:.5} of the diagonal off, confidence {confidence:.3}; left {left:.1e}"
        );
        assert!((0.9 * said..1.1 * said).contains(&off) && confidence > 0.8 && left < 1e-5);
    }
}

#[test]
fn joints_suffice_where_their_error_is_invisible() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let pose = arm::pose(&arm::EXAMPLES, 35);
    let (full, _) = palette(&envelope, &pose);
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut found = vec![Matrix3x4::default(); envelope.palette_len()];
    let certificate = envelope.certificate();
    assert!(certificate.base_training_rms > 2.0 * certificate.training_rms);
    seen::palette_seen(&envelope, (&pose, &[]), 0.0, &mut scratch, &mut found).unwrap();
    assert_eq!(found, full);
    let seen = 2.0 * certificate.base_training_rms;
    seen::palette_seen(&envelope, (&pose, &[]), seen, &mut scratch, &mut found).unwrap();
    let off = farthest(&skinned(&model, &found), &skinned(&model, &full), certificate.diagonal);
    assert!(off > 0.0 && off < 0.2, "{off}");
}

#[test]
fn bones_of_affine_helpers_move_the_skin_a_little() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let pose = arm::pose(&arm::EXAMPLES, 35);
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut found = vec![Matrix3x4::default(); envelope.palette_len()];
    let mut out = vec![Trs::IDENTITY; envelope.proxy_len()];
    bones::bones(&envelope, &pose, &[], &mut scratch, &mut found, &mut out).unwrap();
    let expected = skinned(&model, &found);
    for (l, bone) in out.iter().enumerate() {
        let centre = envelope.helper_centre(l).unwrap();
        found[envelope.joint_len() + l] = bone.palette_entry(centre);
    }
    let certificate = envelope.certificate();
    let off = farthest(&skinned(&model, &found), &expected, certificate.diagonal);
    println!("bones: {off:.5} of the diagonal off at most");
    assert!(off > 1e-4 && off < 1.01 * certificate.trs_error / certificate.diagonal, "{off}");
}

/// Distance of the arm and RMS error of its skin, both in metres: the figures of the page.
const FAR: [(f32, f32); 3] = [(1e3, 7e-5), (1e4, 1e-3), (1e5, 8e-3)];

#[test]
fn a_far_pose_has_the_error_of_the_page_and_a_near_camera_has_none() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let pose = arm::pose(&arm::EXAMPLES, 36);
    let (near, _) = palette(&envelope, &pose);
    let expected = skinned(&model, &near);
    let world = |distance: f32| -> Matrix3x4 {
        [[1.0, 0.0, 0.0, distance], [0.0, 1.0, 0.0, distance], [0.0, 0.0, 1.0, 0.0]]
    };
    let rms = |found: &[[f32; 3]], distance: f32| {
        let off = |(found, own): (&[f32; 3], &[f32; 3])| {
            let distance = f64::from(distance);
            let own = own.map(f64::from);
            let own = [own[0] + distance, own[1] + distance, own[2]];
            (0..3).map(|c| (f64::from(found[c]) - own[c]).powi(2)).sum::<f64>()
        };
        let all = found.iter().zip(&expected).map(off).sum::<f64>();
        (all / expected.len() as f64).sqrt() as f32
    };
    for (distance, said) in FAR {
        let far: Vec<_> = pose.iter().map(|matrix| product(&world(distance), matrix)).collect();
        let (far, confidence) = palette(&envelope, &far);
        let off = rms(&skinned(&model, &far), distance);
        println!("far: {distance:e} m: {off:.1e} m, confidence {confidence:.3}");
        assert!((0.5 * said..1.5 * said).contains(&off) && confidence > 0.99, "{off}");
    }
    // A camera 2 m away from the arm, far out.
    let mut placed = near.clone();
    place(&world(2.0), &mut placed);
    let off = rms(&skinned(&model, &placed), 2.0);
    println!("far: beside the camera {off:.1e} m");
    assert!(off < 1e-6, "{off}");
}
