//! Poses from rest frames and from a larger skeleton; joints and curves bound by names.

use super::{ACTOR, after, apart, each, posed, sample, still, turned};
use crate::common::{call_error, length_error};
use models::{JOINTLESS, Pieces, SMALL, STRETCHING, Shape};
use sinew_runtime::envelope::{BoundJoints, FOLDED, PoseFaultKind as Kind, Predictor};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Envelope, Matrix3x4, Model, gather_pose, matrix,
    model_space_pose_under,
};

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
    let envelope = model.first::<Envelope>().unwrap();
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
        assert_eq!((found.kind, found.argument), (CallErrorKind::TooShort, Argument::World));
        assert_eq!((found.index, found.expected, found.found), (len - 1, len, len - 1));
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
