//! Poses of an engine: from rest frames, from a larger skeleton, checked, scaled, with levels.

use crate::common::{call_error, length_error};
use models::{GOLDEN, JOINTLESS, Pieces, SMALL, STRETCHING, Shape};
use sinew_runtime::envelope::{
    BoundJoints, CURVE_MARGIN, FOLDED, Level, LocalTransform, PoseFault, PoseFaultKind as Kind,
    Predictor, RIGID_TOLERANCE, STRETCH_MARGIN,
};
use sinew_runtime::format::SectionKind;
use sinew_runtime::skin::{Output, Rest, cells};
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Envelope, Matrix3x4, Model, SkinJob, gather_pose, matrix,
    model_space_pose, model_space_pose_under, scale_palette, take_scale,
};

/// Runs a test on the envelopes of the golden files and of samples. One sample stretches joints 1
/// and 2 and has curves.
fn each(test: impl Fn(&Envelope<'_>)) {
    let samples = [SMALL, STRETCHING].map(|shape| Pieces::sample(Predictor::Kernel, shape).bytes());
    for file in GOLDEN.into_iter().chain(samples.each_ref().map(Vec::as_slice)) {
        test(&Model::from_bytes(file).unwrap().envelope().unwrap());
    }
}

/// A pose with each joint rotated against its rest frame, about its own axis.
fn turned(envelope: &Envelope<'_>, angle: f32) -> Vec<LocalTransform> {
    let turn = |(joint, local): (usize, LocalTransform)| {
        let (sine, cosine) = (0.5 * angle * (1.0 + joint as f32)).sin_cos();
        let axis = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [0.8, -0.6, 0.0]][joint % 3];
        let [x, y, z] = axis.map(|a| sine * a);
        let ([a, b, c, d], w) = (local.rotation, cosine);
        let rotation = [
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ];
        LocalTransform { rotation, ..local }
    };
    envelope.rest_locals().enumerate().map(turn).collect()
}

/// The curves at rest.
fn still(envelope: &Envelope<'_>) -> Vec<f32> {
    vec![0.0; envelope.curve_len()]
}

fn posed(envelope: &Envelope<'_>, local: &[LocalTransform]) -> Vec<Matrix3x4> {
    let mut pose = vec![matrix::IDENTITY; local.len()];
    model_space_pose(envelope, local, &mut pose).unwrap();
    pose
}

fn apart(a: &[Matrix3x4], b: &[Matrix3x4]) -> f32 {
    let pairs = a.as_flattened().as_flattened().iter().zip(b.as_flattened().as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn after(a: &Matrix3x4, b: &Matrix3x4) -> Matrix3x4 {
    let entry = |row: &[f32; 4], c: usize| {
        (0..3).map(|k| row[k] * b[k][c]).sum::<f32>() + if c == 3 { row[3] } else { 0.0 }
    };
    a.map(|row| std::array::from_fn(|c| entry(&row, c)))
}

const ACTOR: Matrix3x4 = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, -0.25], [0.0, 0.0, 1.0, 3.5]];

#[test]
fn rest_frames_make_the_rest_pose() {
    each(|envelope| {
        let local: Vec<_> = envelope.rest_locals().collect();
        assert_eq!(local.len(), envelope.joint_len());
        let pose = posed(envelope, &local);
        assert!(apart(&pose, &vec![matrix::IDENTITY; local.len()]) < 2e-6, "{pose:?}");
        assert_eq!(envelope.rest_local(local.len()), None);
        assert_eq!(envelope.rest_frame(local.len()), None);
        for (joint, bind) in envelope.inverse_binds().enumerate() {
            assert_eq!(envelope.inverse_bind(joint), Some(bind));
            let frame = envelope.rest_frame(joint).unwrap();
            assert!(apart(&[after(&bind, &frame)], &[matrix::IDENTITY]) < 1e-6);
        }
        assert!(apart(&posed(envelope, &turned(envelope, 0.5)), &pose) > 0.1);
    });
}

#[test]
fn a_root_carries_the_whole_pose() {
    each(|envelope| {
        let local = turned(envelope, 0.5);
        let expected: Vec<_> = posed(envelope, &local).iter().map(|m| after(&ACTOR, m)).collect();
        let mut pose = vec![matrix::IDENTITY; local.len()];
        model_space_pose_under(&ACTOR, envelope, &local, &mut pose).unwrap();
        assert!(apart(&pose, &expected) < 1e-5);
        let before = pose.clone();
        let wrong = ACTOR.map(|row| row.map(|x| x / 0.0));
        let refused = model_space_pose_under(&wrong, envelope, &local, &mut pose);
        assert_eq!(refused, Err(call_error(CallErrorKind::NonFinite, Argument::Root)));
        assert_eq!(pose, before);
    });
}

#[test]
fn a_larger_skeleton_is_gathered_by_names() {
    each(|envelope| {
        let len = envelope.joint_len();
        let pose = posed(envelope, &turned(envelope, 0.5));
        let frame = |joint: usize| after(&pose[joint], &envelope.rest_frame(joint).unwrap());
        // The joints in reverse order, each after an extra twist joint of the engine, in a shifted
        // world.
        let names: Vec<String> = (0..len)
            .rev()
            .flat_map(|joint| {
                [format!("twist {joint}"), envelope.joint_name(joint).unwrap().to_owned()]
            })
            .collect();
        let world: Vec<_> =
            (0..len).rev().flat_map(|joint| [ACTOR, after(&ACTOR, &frame(joint))]).collect();
        let mut map = vec![0; len];
        let bound = envelope.bind_joints(&names, &mut map).unwrap();
        assert_eq!(bound, BoundJoints { found_len: len, missing_parent: None });
        let mut out = vec![matrix::IDENTITY; len];
        gather_pose(envelope, &map, &world, None, &mut out).unwrap();
        let expected: Vec<_> = pose.iter().map(|m| after(&ACTOR, m)).collect();
        assert!(apart(&out, &expected) < 1e-5);
        // The inverse of the actor's matrix undoes the shift.
        let back = [[0.0, 1.0, 0.0, 0.25], [-1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, -3.5]];
        gather_pose(envelope, &map, &world, Some(&back), &mut out).unwrap();
        assert!(apart(&out, &pose) < 1e-5);
        // A joint that the skeleton lacks follows its parent.
        let lacking = (0..len).find(|joint| *joint != envelope.root());
        if let Some(joint) = lacking {
            let own = |name: &&String| Some(name.as_str()) != envelope.joint_name(joint);
            let world: Vec<_> =
                names.iter().zip(&world).filter(|(name, _)| own(name)).map(|(_, m)| *m).collect();
            let names = names.iter().filter(own);
            let bound = envelope.bind_joints(names, &mut map).unwrap();
            assert_eq!(bound.found_len, len - 1);
            gather_pose(envelope, &map, &world, Some(&back), &mut out).unwrap();
            assert_eq!(map[joint], FOLDED);
            assert_eq!(out[joint], out[envelope.parent(joint).unwrap()]);
        }
    });
}

/// A file of five named joints: 1 is the root, 2 is its child, 0 is a child of 2, and then 3 and 4
/// form a chain.
fn named(names: [&str; 5]) -> Vec<u8> {
    let shape = Shape { joints: 5, ..SMALL };
    let mut pieces = Pieces::sample(Predictor::Kernel, shape);
    let joints: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    *pieces.section(SectionKind::Names) = models::names("body", &joints);
    pieces.bytes()
}

#[test]
fn joints_under_other_names_are_refused_and_counted() {
    let file = named(["Head", "Hips", "Chest", "Hand.L", "Hand.R"]);
    let model = Model::from_bytes(file).unwrap();
    let envelope = model.envelope().unwrap();
    let (root, parent) = (envelope.root(), |joint| envelope.parent(joint).unwrap());
    assert_eq!((root, parent(0), parent(2)), (1, 2, 1));
    let bind = |names: &[&str]| {
        let mut map = vec![7; 5];
        let bound = envelope.bind_joints(names, &mut map);
        assert_eq!(bound.is_err(), map == [7; 5], "nothing is written");
        bound.map(|bound| (bound, map))
    };
    let own = ["Head", "Hips", "Chest", "Hand.L", "Hand.R"];
    let all = BoundJoints { found_len: 5, missing_parent: None };
    assert_eq!(bind(&own), Ok((all, vec![0, 1, 2, 3, 4])));
    // A difference in prefix, case or separators: each is named, with its place.
    let other = |index, found| {
        Err(CallError { index, found, ..call_error(CallErrorKind::OtherName, Argument::Names) })
    };
    assert_eq!(
        bind(&own.map(|name| ["world", name].join(":")).each_ref().map(String::as_str)),
        other(0, 0)
    );
    assert_eq!(bind(&own.map(str::to_uppercase).each_ref().map(String::as_str)), other(0, 0));
    assert_eq!(bind(&["world", "mixamorig:Head", "Hips"]), other(0, 1));
    assert_eq!(bind(&["Head", "Hips", "Chest", "Hand_R", "Hand.L"]), other(4, 3));
    assert_eq!(bind(&["Head", "hips", "Chest"]), other(1, 1));
    let said = bind(&["Head", "hips", "Chest"]).unwrap_err().to_string();
    assert!(said.starts_with("names: name 1 is joint 1 with another prefix, case"), "{said}");
    // Only the root, or not even the root.
    let none =
        CallError { expected: 5, found: 1, ..call_error(CallErrorKind::NoJoints, Argument::Names) };
    assert_eq!(bind(&["Hips", "weapon"]), Err(none));
    assert!(none.to_string().contains("the root alone of 5 joints"), "{none}");
    let no_root = CallError { index: 1, ..call_error(CallErrorKind::NoRoot, Argument::Names) };
    assert_eq!(bind(&["Head", "Chest", "Hand.L", "Hand.R"]), Err(no_root));
    assert_eq!(bind(&[]), Err(no_root));
    // A reduced skeleton is bound. Only a joint that lacks its parent is reported.
    let reduced = BoundJoints { found_len: 2, missing_parent: None };
    assert_eq!(bind(&["Hips", "Chest"]), Ok((reduced, vec![FOLDED, 0, 1, FOLDED, FOLDED])));
    let gap = BoundJoints { found_len: 2, missing_parent: Some(2) };
    assert_eq!(bind(&["Head", "Hips"]), Ok((gap, vec![0, 1, FOLDED, FOLDED, FOLDED])));
}

#[test]
fn invalid_bindings_and_gathers_are_refused() {
    each(|envelope| {
        let (len, root) = (envelope.joint_len(), envelope.root());
        let mut map = vec![7; len];
        let no_root =
            |argument| CallError { index: root, ..call_error(CallErrorKind::NoRoot, argument) };
        let found = envelope.bind_joints(["weapon"], &mut map);
        assert_eq!(found, Err(no_root(Argument::Names)));
        assert!(found.unwrap_err().to_string().contains("the root, is not among them"));
        let found = envelope.bind_joints(["weapon"], &mut map[1..]);
        assert_eq!(found, Err(length_error(Argument::Joints, len, len - 1)));
        assert_eq!(map, vec![7; len]);
        let mut out = vec![ACTOR; len];
        let world = vec![matrix::IDENTITY; len];
        let sound: Vec<u32> = (0..len as u32).collect();
        let mut gather = |map: &[u32], world: &[Matrix3x4], root: Option<&Matrix3x4>| {
            let found = gather_pose(envelope, map, world, root, &mut out).unwrap_err();
            assert_eq!(out, vec![ACTOR; len]);
            found
        };
        let mut folded = sound.clone();
        folded[root] = FOLDED;
        assert_eq!(gather(&folded, &world, None), no_root(Argument::Joints));
        let found = gather(&sound, &world[1..], None);
        assert_eq!((found.kind, found.argument), (CallErrorKind::OutOfRange, Argument::Joints));
        assert_eq!((found.index, found.found), (len - 1, len - 1));
        let unknown = [[f32::NAN; 4]; 3];
        let found = gather(&sound, &[&world[1..], &[unknown]].concat(), None);
        assert_eq!((found.kind, found.argument), (CallErrorKind::NonFinite, Argument::World));
        assert_eq!(found.index, len - 1);
        let found = gather(&sound, &world, Some(&unknown));
        assert_eq!(found, call_error(CallErrorKind::NonFinite, Argument::Root));
        assert_eq!(gather(&sound[1..], &world, None).argument, Argument::Joints);
    });
}

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
fn a_scaled_actor_is_the_scaled_skin() {
    for file in GOLDEN {
        let model = Model::from_bytes(file).unwrap();
        let (envelope, skin) = (model.envelope().unwrap(), model.skin().unwrap());
        let evaluate = |mut pose: Vec<Matrix3x4>| {
            let scale = take_scale(&mut pose);
            let mut palette = vec![matrix::IDENTITY; envelope.palette_len()];
            let mut scratch = vec![0.0; envelope.scratch_len()];
            envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap();
            scale_palette(&mut palette, scale);
            let mut out = vec![0.0; 6 * skin.vertex_len()];
            let floats = cells(&mut out);
            SkinJob {
                skin,
                palette: &palette,
                vertices: 0..skin.vertex_len(),
                remap: None,
                rest: Rest::default(),
                positions: Some(Output { floats, stride: 6 }),
                normals: Some(Output { floats: &floats[3..], stride: 6 }),
                tangents: None,
            }
            .run()
            .unwrap();
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
        let envelope = model.envelope().unwrap();
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
fn levels_are_the_palette_with_and_without_its_correction() {
    each(|envelope| {
        let pose = posed(envelope, &turned(envelope, 0.25));
        let (curves, mut scratch) = (still(envelope), vec![0.0; envelope.scratch_len()]);
        let mut at = |level: Option<Level>| {
            let mut palette = vec![matrix::IDENTITY; envelope.palette_len()];
            let confidence = match level {
                Some(level) => {
                    envelope.palette_at(level, &pose, &curves, &mut scratch, &mut palette)
                }
                None => envelope.palette(&pose, &curves, &mut scratch, &mut palette),
            };
            (palette, confidence.unwrap())
        };
        assert_eq!(at(Some(Level::default())), at(None));
        let (base, confidence) = at(Some(Level::Joints));
        assert!((0.0..=1.0).contains(&confidence));
        if !envelope.predictor().corrects() {
            assert_eq!((base, confidence), at(None));
        } else if !envelope.predictor().reconstructs() {
            assert_eq!((&base[..pose.len()], confidence), (&*pose, 1.0));
            for group in envelope.groups() {
                for helper in &base[pose.len()..][group.proxies.clone()] {
                    assert_eq!(*helper, pose[group.joint]);
                }
            }
        } else {
            assert_ne!(base, at(None).0);
        }
        let refused = envelope.palette_at(Level::Joints, &pose, &curves, &mut [], &mut []);
        assert_eq!(refused.unwrap_err().argument, Argument::Palette);
    });
}

/// Runs a test on the envelope of a kernel sample.
fn sample(shape: Shape, test: impl FnOnce(&Envelope<'_>)) {
    let model = Model::from_bytes(Pieces::sample(Predictor::Kernel, shape).bytes()).unwrap();
    test(&model.envelope().unwrap());
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
    let envelope = model.envelope().unwrap();
    assert_eq!(envelope.check_pose(&[], &[1e9; 5]), Ok(()));
    let fault = envelope.check_pose(&[], &[0.0, 0.0, 0.0, 0.0, f32::NAN]).unwrap_err();
    assert_eq!((fault.kind, fault.joint), (Kind::Curve, 4));
}

#[test]
fn curves_are_bound_by_names() {
    sample(STRETCHING, |envelope| {
        assert_eq!(envelope.curve_name(0), Some("curve 0"));
        assert_eq!((envelope.curve_name(3), envelope.curve_name(usize::MAX)), (None, None));
        let mut map = [9; 3];
        let bound =
            envelope.bind_curves(["curve 2", "other", "curve 0", "curve 1", "curve 0"], &mut map);
        assert_eq!((bound, map), (Ok(()), [2, 3, 0]));
        // A curve that is missing is named, and nothing is written. Joints are no curves.
        let mut map = [9; 3];
        let missing =
            |index| CallError { index, ..call_error(CallErrorKind::NoCurve, Argument::Names) };
        let names = ["curve 0", "Curve 1", "curve 2", "joint 1"];
        assert_eq!(envelope.bind_curves(names, &mut map), Err(missing(1)));
        assert_eq!(envelope.bind_curves(["curve"; 0], &mut map), Err(missing(0)));
        let short = envelope.bind_curves(names, &mut map[1..]);
        assert_eq!(short, Err(length_error(Argument::Curves, 3, 2)));
        assert_eq!(map, [9; 3]);
        let said = missing(1).to_string();
        assert!(said.starts_with("names: curve 1 is not among them"), "{said}");
    });
    sample(SMALL, |envelope| {
        assert_eq!(envelope.curve_name(0), None);
        assert_eq!(envelope.bind_curves(["curve 0"], &mut []), Ok(()));
    });
}

#[test]
fn a_model_without_joints_takes_an_empty_pose() {
    sample(JOINTLESS, |envelope| {
        assert_eq!((envelope.joint_len(), envelope.root(), envelope.palette_len()), (0, 0, 3));
        assert_eq!((envelope.joint_name(0), envelope.stretch_range(0)), (None, None));
        assert_eq!(envelope.curve_name(4), Some("curve 4"));
        assert_eq!(envelope.curve_range(4), Some([-0.5, 0.5]));
        assert!(posed(envelope, &[]).is_empty());
        let bound = envelope.bind_joints(["hip"], &mut []).unwrap();
        assert_eq!(bound, BoundJoints { found_len: 0, missing_parent: None });
        assert_eq!(gather_pose(envelope, &[], &[], None, &mut []), Ok(()));
        assert_eq!(envelope.check_pose(&[], &still(envelope)), Ok(()));
        let one = [matrix::IDENTITY];
        assert_eq!(envelope.check_pose(&one, &still(envelope)).unwrap_err().kind, Kind::Length);
        let mut scratch = vec![0.0; envelope.scratch_len()];
        envelope.joint_confidences(&[], &still(envelope), &mut scratch, &mut []).unwrap();
    });
}
