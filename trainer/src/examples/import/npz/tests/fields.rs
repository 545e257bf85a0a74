//! Tests of optional fields: clips, meshes, weights, importance and space.

use sinew_runtime::format::{Axis, Handedness, Space};

use super::*;
use crate::examples::{Clip, Source, load_poses};

/// Cuts the four frames into two clips with source frame numbers, at 24 frames per second.
fn clips() -> Set {
    Set::good()
        .words("clip_names", &["Walk Cycle", "Stretch"])
        .count("clip_starts", &[0, 3])
        .count("frame_numbers", &[1, 2, 4, 67])
        .row("fps", &[24.0])
}

fn expected() -> Vec<Clip> {
    let clip = |name: &str, first, times: &[f64], numbers: &[i64]| Clip {
        name: name.to_owned(),
        first,
        times: times.to_vec(),
        numbers: Some(numbers.to_vec()),
    };
    vec![
        clip("Walk Cycle", 0, &[0.0, 1.0 / 24.0, 3.0 / 24.0], &[1, 2, 4]),
        clip("Stretch", 3, &[0.0], &[67]),
    ]
}

#[test]
fn clips_have_names_times_and_numbers() {
    assert_eq!(clips().load("clips").unwrap().clips, expected());
    let joints = json!({"bone_names": ["root", "tip"], "bone_parents": [-1, 0]});
    let mut all = joints.clone();
    for (key, value) in [
        ("clip_names", json!(["Walk Cycle", "Stretch"])),
        ("clip_starts", json!([0, 3])),
        ("fps", json!(24)),
    ] {
        all[key] = value;
    }
    let set = Set::good().count("frame_numbers", &[1, 2, 4, 67]).json(all);
    assert_eq!(set.load("clips-json").unwrap().clips, expected());
}

#[test]
fn without_clips_all_frames_are_one_clip_at_thirty_a_second() {
    let clips = Set::good().load("one-clip").unwrap().clips;
    let times = (0..4).map(|frame| f64::from(frame) / 30.0).collect();
    let whole = |times, numbers| Clip { name: "set".to_owned(), first: 0, times, numbers };
    assert_eq!(clips, [whole(times, None)]);
    let clips = Set::good().count("frame_numbers", &[-7, -5, 1, 2]).load("numbers").unwrap().clips;
    let times = [0.0, 2.0, 8.0, 9.0].map(|frame| frame / 30.0).to_vec();
    assert_eq!(clips, [whole(times, Some(vec![-7, -5, 1, 2]))]);
}

#[test]
fn one_clip_is_read_alone() {
    let folder = Folder::new("clip-alone");
    let moved = clips().real("vertices", 3 * 15, 0.25).real("bone_transforms", 3 * 32 + 3, 0.5);
    let path = moved.whole("split", 3, 0).write(&folder);
    let of = |clip: &str| {
        let clips = &[clip.to_owned()];
        let one =
            Sampling { fps: None, clips, shapes: true, still: false, played: false, curves: false };
        load_clips(&path, &one).map(|(loaded, _)| loaded)
    };
    let Loaded { examples, clips, .. } = of("Stretch").unwrap();
    assert_eq!(clips, [Clip { first: 0, ..expected()[1].clone() }]);
    assert_eq!((examples.frame_len(), examples.frame(0)[0]), (1, [0.25, 0.0, 0.0]));
    assert_eq!((examples.split[0], examples.pose(0)[0][0][3]), (Split::Train, 0.5));
    let Loaded { examples, clips, .. } = of("Walk Cycle").unwrap();
    assert_eq!(clips, expected()[..1]);
    assert_eq!((examples.frame_len(), examples.vertices.len()), (3, 15));
    let error = of("Run").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert_eq!(error.message(), "has no clip Run, there are: Walk Cycle, Stretch");
}

#[test]
fn errors_and_warnings_name_frames_by_their_source_number() {
    let fault = |set: Set| set.fault("called");
    let found = fault(clips().real("vertices", 3 * 15, f64::NAN));
    let words = "array vertices is not finite at vertex 0";
    assert_eq!((found.frame(), found.message()), (Some(67), words));
    let found = fault(clips().real("vertices", 15 + 3, 1e30));
    let words = "array vertices exceeds 1e9, the most a model can hold, at vertex 1";
    assert_eq!((found.frame(), found.message()), (Some(2), words));
    for (place, number) in [(0, -1.0), (15, 2.0)] {
        let found = fault(clips().real("bone_transforms", 32 + 16 + place, number));
        assert_eq!(found.frame(), Some(2));
        assert!(found.message().starts_with("joint tip "), "{found}");
    }
    let near = clips().real("bone_transforms", 32 + 16, 1.001).load("called-near").unwrap();
    let [Warning::NonRigidJoint { worst_frame: Some(2), .. }] = &near.warnings[..] else {
        panic!("{:?}", near.warnings)
    };
}

#[test]
fn meshes_become_ranges_and_importance_is_read() {
    let set = Set::good().words("mesh_names", &["Body", "Sleeve"]).count("mesh_starts", &[0, 3]);
    let set = set.row("importance", &[1.0, 1.0, 0.0, 0.5, 2.5]);
    let examples = set.load("meshes").unwrap().examples;
    assert_eq!(examples.ranges, [("Body".to_owned(), 0..3), ("Sleeve".to_owned(), 3..5)]);
    assert_eq!(examples.importance, Some(vec![1.0, 1.0, 0.0, 0.5, 2.5]));
}

#[test]
fn painted_joint_weights_are_read_and_saved() {
    assert_eq!(Set::good().load("painted-none").unwrap().examples.joint_weights, None);
    let weights = [1.0, 0.0, 0.5, 0.5, 0.0, 2.0, 0.0, 0.0, 0.25, 0.75];
    let painted = |shape: &[u64], place: usize, number: f64| {
        let mut set = Set::good();
        let mut weights = weights.to_vec();
        weights[place] = number;
        weights.truncate(shape.iter().product::<u64>() as usize);
        set.reals.insert("joint_weights", (shape.to_vec(), weights));
        set
    };
    let loaded = painted(&[5, 2], 0, 1.0).load("painted").unwrap().examples;
    assert_eq!(loaded.joint_weights.as_deref(), Some(&weights[..]));
    let folder = Folder::new("painted-saved");
    save_npz(&folder.npz(), &loaded, &[]).unwrap();
    assert_eq!(load(&folder.npz()).unwrap().examples.joint_weights, loaded.joint_weights);
    for (set, words) in [
        (painted(&[4, 2], 0, 1.0), "rest has 5 vertices, joint_weights has 4"),
        (painted(&[5, 1], 0, 1.0), "bone_names has 2 joints, joint_weights has 1"),
        (painted(&[10], 0, 1.0), "array joint_weights must have shape [n, n], found [10]"),
        (painted(&[5, 2], 7, -0.5), "joint_weights has -0.5 at vertex 3, joint tip, expected a"),
        (painted(&[5, 2], 2, f64::NAN), "joint_weights has NaN at vertex 1, joint root, expected"),
    ] {
        let fault = set.fault("painted-bad");
        assert!(fault.message().contains(words), "{fault}");
    }
}

#[test]
fn frame_weights_are_read_and_saved() {
    let len = Set::good().load("weights-none").unwrap().examples.frame_len();
    let mut weights = vec![1.0; len];
    weights[1] = 3.0;
    let loaded = Set::good().row("frame_weights", &weights).load("weights").unwrap().examples;
    let expected: Vec<usize> = (0..len).flat_map(|f| vec![f; weights[f] as usize]).collect();
    assert_eq!(loaded.repeated(&Vec::from_iter(0..len)), expected);
    let folder = Folder::new("weights-saved");
    save_npz(&folder.npz(), &loaded, &[]).unwrap();
    assert_eq!(load(&folder.npz()).unwrap().examples.frame_weights, loaded.frame_weights);
    weights[1] = 0.5;
    let refused = Set::good().row("frame_weights", &weights).load("weights-bad").unwrap_err();
    let text = "frame 1: array frame_weights has 0.5, expected a whole number from 1 to 100";
    assert!(refused.to_string().contains(text), "{refused}");
}

#[test]
fn axes_and_unit_are_read_and_saved() {
    let told = Set::good().words("up", &["z"]).words("forward", &["-y"]).row("unit", &[0.01]);
    let space = Space {
        up: Some(Axis::Z),
        forward: Some(Axis::MinusY),
        handedness: Handedness::Right,
        unit: Some(0.01),
    };
    assert_eq!(told.load("space").unwrap().examples.space, space);
    let json = json!({"bone_names": ["root", "tip"], "bone_parents": [-1, 0],
        "up": "z", "forward": "-y", "handedness": "left", "unit": 0.01});
    let mut saved = Set::good().json(json).load("space-json").unwrap().examples;
    assert_eq!(saved.space, Space { handedness: Handedness::Left, ..space });
    saved.set_importance(vec![0.5, 1.0, 1.0, 1.0, 1.5]).unwrap();
    let folder = Folder::new("space-saved");
    save_npz(&folder.npz(), &saved, &[]).unwrap();
    let loaded = load(&folder.npz()).unwrap().examples;
    assert_eq!((loaded.space, loaded.importance), (saved.space, saved.importance));
    assert_eq!(Set::good().load("space-none").unwrap().examples.space, Space::default());
}

#[test]
fn clips_and_meshes_are_saved_and_load_the_same() {
    let meshes = |set: Set| set.words("mesh_names", &["Body", "袖"]).count("mesh_starts", &[0, 3]);
    let saved = meshes(clips()).load("clips-first").unwrap();
    let folder = Folder::new("clips-saved");
    save_npz(&folder.npz(), &saved.examples, &saved.clips).unwrap();
    let loaded = load(&folder.npz()).unwrap();
    assert_eq!((&loaded.clips, &loaded.examples.ranges), (&saved.clips, &saved.examples.ranges));
    // The clips have no frame numbers and no common rate.
    let mut clips = expected();
    clips.iter_mut().for_each(|clip| clip.numbers = None);
    clips[0].times = vec![0.0, 0.5, 0.6];
    save_npz(&folder.npz(), &saved.examples, &clips).unwrap();
    let loaded = load(&folder.npz()).unwrap().clips;
    assert_eq!(loaded[0].times, [0.0, 1.0 / 30.0, 2.0 / 30.0]);
    assert!(loaded.iter().all(|clip| clip.numbers.is_none()));
}

#[test]
fn played_poses_without_a_rate_give_a_warning() {
    let played = |set: Set, test: &str, fps: Option<f64>| {
        let folder = Folder::new(test);
        let path = set.write(&folder);
        let source = Source { fps, ..Source::file(&path) };
        let Loaded { clips, warnings, .. } = load_poses(&source).unwrap();
        (clips[0].times[1], warnings)
    };
    let bare = Set::good;
    assert_eq!(played(bare(), "unrated", None), (1.0 / 30.0, vec![Warning::NoRate]));
    assert_eq!(played(bare(), "rated", Some(12.0)), (1.0 / 12.0, vec![]));
    assert_eq!(played(clips(), "rated-itself", None), (1.0 / 24.0, vec![]));
    assert_eq!(played(clips(), "rated-anew", Some(12.0)), (1.0 / 12.0, vec![]));
    assert_eq!(bare().load("only-read").unwrap().warnings, []);
    let told = Warning::NoRate.to_string();
    assert_eq!(
        told,
        "it gives no frames per second (fps) and plays at 30: give another rate with --fps"
    );
}

#[test]
fn wrong_fields_name_array_and_place() {
    let names = |set: Set| set.words("clip_names", &["a", "b"]);
    let starts = "expected 0 for the first, then ascending numbers below 4";
    for (set, words) in [
        (names(Set::good()), "array clip_starts is missing".to_owned()),
        (Set::good().count("mesh_starts", &[0]), "array mesh_names is missing".to_owned()),
        (
            names(Set::good()).count("clip_starts", &[0]),
            "clip_names has 2 clips, clip_starts has 1".to_owned(),
        ),
        (
            names(Set::good()).count("clip_starts", &[1, 2]),
            format!("array clip_starts has 1 for a, {starts}"),
        ),
        (
            names(Set::good()).count("clip_starts", &[0, 4]),
            format!("array clip_starts has 4 for b, {starts}"),
        ),
        (
            names(Set::good()).count("clip_starts", &[0, 0]),
            format!("array clip_starts has 0 for b, {starts}"),
        ),
        (
            names(Set::good()).count("clip_starts", &[0, -1]),
            format!("array clip_starts has -1 for b, {starts}"),
        ),
        (
            Set::good().words("clip_names", &[]).count("clip_starts", &[]),
            "array clip_names is empty".to_owned(),
        ),
        (
            clips().count("frame_numbers", &[1, 2, 3]),
            "vertices has 4 frames, frame_numbers has 3".to_owned(),
        ),
        (
            clips().count("frame_numbers", &[1, 2, 2, 67]),
            "frame 2: array frame_numbers has 2, expected 3 to 2147483647: numbers ascend in \
             each clip"
                .to_owned(),
        ),
        (
            clips().count("frame_numbers", &[1, 2, i64::MAX, 67]),
            "frame 2: array frame_numbers has 9223372036854775807, expected 3 to 2147483647: \
             numbers ascend in each clip"
                .to_owned(),
        ),
        (
            clips().row("fps", &[0.0]),
            "array fps has 0, expected 0.001 to 10000 frames a second".to_owned(),
        ),
        (
            clips().row("fps", &[f64::NAN]),
            "array fps has NaN, expected 0.001 to 10000 frames a second".to_owned(),
        ),
        (
            clips().row("fps", &[24.0, 25.0]),
            "array fps must have shape [] or [1], found [2]".to_owned(),
        ),
        (
            clips().words("fps", &["24"]).without("fps"),
            "array fps must hold numbers, found dtype '<U2'".to_owned(),
        ),
        (
            Set::good().row("importance", &[1.0; 4]),
            "rest has 5 vertices, importance has 4".to_owned(),
        ),
        (
            Set::good().row("importance", &[1.0, 1.0, -2.0, 1.0, 1.0]),
            "the importance of vertex 2 must be finite and not negative, found -2".to_owned(),
        ),
        (
            Set::good().words("up", &["up"]),
            "array up has \"up\", expected x, -x, y, -y, z or -z".to_owned(),
        ),
        (
            Set::good().words("handedness", &["both"]),
            "array handedness has \"both\", expected right or left".to_owned(),
        ),
        (
            Set::good().words("up", &["z", "y"]),
            "array up must have shape [] or [1], found [2]".to_owned(),
        ),
        (
            Set::good().words("up", &["z"]).words("forward", &["-z"]),
            "up z and forward -z lie along one line: give an up and a forward that are square to \
             each other"
                .to_owned(),
        ),
        (
            Set::good().row("unit", &[-1.0]),
            "a unit of -1 m: expected a length from 1e-9 to 1e9 m".to_owned(),
        ),
    ] {
        let fault = set.fault("told").to_string();
        let found = fault.split_once("set.npz: ").map(|(_, found)| found);
        assert_eq!(found, Some(words.as_str()));
    }
    let joints = json!({"bone_names": ["root", "tip"], "bone_parents": [-1, 0], "fps": "24"});
    let error = Set::good().json(joints).load("told-json").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Damaged);
    assert!(error.file().is_some_and(|file| file.ends_with("set.json")), "{error}");
    assert!(error.message().starts_with("is not a description of examples: "), "{error}");
}
