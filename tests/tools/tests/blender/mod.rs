//! Runs the Blender script in the `bpy` package: the exported examples must match the scene.

mod dressed;

use sinew_runtime::format::{Axis, Space};
use sinew_trainer::examples::{Clip, Examples, Loaded, Source, Warning, load, load_motion, npz};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Returns the Python that has `bpy`; `None` if `cargo xtask test` could not install `bpy`.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("SINEW_BPY").expect(
        "SINEW_BPY must name a Python with bpy (`pip install bpy==5.0.1`), as `cargo xtask test` \
         arranges",
    );
    if python.is_empty() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but bpy does not install here");
        eprintln!("not run: bpy does not install here");
        return None;
    }
    Some(python.into())
}

fn run(python: &Path, script: &str, arguments: &[&str]) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join(script);
    Command::new(python).arg(script).args(arguments).output().unwrap()
}

/// Makes the scenes and exports one; returns the script's output and the path of the examples.
fn export(test: &str, scene: &str, more: &[&str]) -> Option<(Output, PathBuf)> {
    let python = python()?;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("blender-{test}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let made = run(&python, "tests/blender/scene.py", &[folder.to_str().unwrap()]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let examples = folder.join("limb.npz");
    Some((of(&python, &folder.join(scene), &examples, more), examples))
}

/// Makes the scene of a script in a folder of the test, and returns the folder.
fn made(python: &Path, script: &str, test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("blender-{test}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let script = format!("tests/blender/{script}.py");
    let made = run(python, &script, &[folder.to_str().unwrap()]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    folder
}

/// Exports a scene.
fn of(python: &Path, scene: &Path, examples: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["--blend", scene.to_str().unwrap(), examples.to_str().unwrap()];
    arguments.extend(more);
    run(python, "../../trainer/blender_export.py", &arguments)
}

/// Returns the script's standard output and its notes.
#[track_caller]
fn done(output: &Output) -> [String; 2] {
    let [said, noted] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{noted}");
    [said.into_owned(), noted.into_owned()]
}

fn near(found: &[f64], expected: &[f64]) {
    let far = found.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-6);
    assert!(!far && found.len() == expected.len(), "{found:?}, expected {expected:?}");
}

#[test]
fn a_scene_becomes_the_examples_that_it_shows() {
    let Some((output, path)) = export("scene", "limb.blend", &[]) else { return };
    let [said, noted] = done(&output);
    let words = "limb.npz: 6 vertices, 2 joints, 3 frames at 24 a second\n  meshes: Limb\n  \
                 clips: RigAction (1 to 3)\n  curves: Swell\n  rest mesh: of frame 1, armature, keys and drivers at \
                 rest\n";
    assert!(said.ends_with(words) && noted.is_empty(), "{said}{noted}");
    let Loaded { examples, clips, warnings } = npz::load(&path).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(clips, [clip("RigAction", 0, 24.0, &[1, 2, 3])]);
    let space = Space { up: Some(Axis::Z), forward: Some(Axis::MinusY), ..Space::GLTF };
    assert_eq!(examples.space, space);
    // A quad, a triangle, and three triangles for the pentagon.
    assert_eq!((examples.vertex_len(), examples.triangles.len()), (6, 2 + 1 + 3));
    assert_eq!(examples.skeleton.names, ["upper", "lower"]);
    assert_eq!(examples.skeleton.parents, [None, Some(0)]);
    near(&examples.skeleton.rest[1].map(|row| row[3]), &[0.0, 0.0, 1.0]);
    near(&examples.rest[5], &[0.3, 0.3, 1.5]);
    let weights = [[1.0, 0.0], [0.75, 0.25], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 1.0]];
    near(examples.joint_weights.as_ref().unwrap(), weights.as_flattened());
    // The bone's x axis stays x: rotated by 90 degrees about it at (0, 0, 1), y becomes z and z
    // becomes -y.
    let bent = examples.pose(2)[1];
    near(&bent[0], &[1.0, 0.0, 0.0, 0.0]);
    near(&bent[1], &[0.0, 0.0, -1.0, 1.0]);
    near(&bent[2], &[0.0, 1.0, 0.0, 1.0]);
    near(&examples.frame(2)[5], &[0.3, -0.5, 1.3]);
    near(&examples.frame(2)[0], &[0.2, 0.0, 0.5]);
    near(&examples.frame(1)[0], &[0.15, 0.0, 0.5]);
    // The keyed shape key is a curve.
    assert_eq!(
        (&examples.curve_names[..], &examples.curves[..]),
        (&["Swell".to_owned()][..], &[0.0, 0.5, 1.0][..])
    );
    // Vertices 2, 3 and 4 have two texture coordinates each.
    let surface = examples.surface();
    let uv = surface.uv().unwrap().iter().enumerate();
    let mut found: Vec<_> = uv.map(|(copy, uv)| (surface.copy_of(copy), *uv)).collect();
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    // Drops copies that differ only in their tangents or normals: the faces are flat.
    found.dedup();
    let expected = [
        (0, [0.0, 0.0]),
        (1, [1.0, 0.0]),
        (2, [1.0, 1.0]),
        (2, [1.0, 2.0]),
        (3, [0.0, 1.0]),
        (3, [0.0, 2.0]),
        (4, [2.0, 3.0]),
        (4, [3.0, 1.0]),
        (5, [3.0, 0.0]),
    ];
    assert_eq!(found, expected);
}

/// Blender's FBX exporter writes other axes and units, and every bone.
#[test]
fn the_same_scene_as_fbx_moves_the_same_joints() {
    let Some((output, path)) = export("fbx", "limb.blend", &[]) else { return };
    done(&output);
    let scene = path.with_extension("fbx");
    let source = Source { targets: Some(&path), ..Source::file(&scene) };
    let Loaded { examples, warnings, .. } = load(&source).unwrap();
    let how = "(x, -z, y) x 0.01".to_owned();
    assert_eq!(warnings, [Warning::Moved { what: "joints", how }]);
    assert_eq!(examples.skeleton.names, ["upper", "control", "lower"]);
    let script = npz::load(&path).unwrap().examples;
    assert_eq!(examples.rest, script.rest);
    let [own, other] = [&examples, &script].map(|read| read.joint_weights.as_ref().unwrap());
    let without_control: Vec<f64> = own.chunks_exact(3).flat_map(|row| [row[0], row[2]]).collect();
    near(&without_control, other);
    for frame in 0..3 {
        for (joint, other) in [(0, 0), (2, 1)] {
            let [found, expected] = [examples.pose(frame)[joint], script.pose(frame)[other]];
            near(found.as_flattened(), expected.as_flattened());
        }
    }
    // Without other files, the scene gives the script's examples in the scene's space: skin and
    // shape key.
    let alone = load(&Source::file(&scene)).unwrap().examples;
    let moved = |&[x, y, z]: &[f64; 3]| [0.01 * x, -0.01 * z, 0.01 * y];
    for frame in 0..3 {
        let found: Vec<_> = alone.frame(frame).iter().map(moved).collect();
        near(found.as_flattened(), script.frame(frame).as_flattened());
    }
}

/// Exports the scene of a driven face; returns the script's output and the path of the examples.
fn driven(test: &str, more: &[&str]) -> Option<(Output, PathBuf)> {
    let python = python()?;
    let folder = made(&python, "driven", test);
    let path = folder.join("driven.npz");
    Some((of(&python, &folder.join("driven.blend"), &path, more), path))
}

/// The rest mesh has animated shape keys and their drivers at rest, whatever the scene's current
/// frame.
#[test]
fn drivers_and_shapes_are_at_rest_in_the_rest_mesh() {
    let Some((output, path)) = driven("driven", &["--frames", "2:3"]) else { return };
    let [said, noted] = done(&output);
    assert!(
        said.ends_with("rest mesh: of frame 2, armature, keys and drivers at rest\n"),
        "{said}"
    );
    let on = "shape keys that are on at rest, as no key moves them: Face Puff (0.50), Face Style (0.50), Face Calm (0.25)";
    assert!(noted.contains(on), "{noted}");
    let driven = "driven, and so no curves: Grin, Tilt, Puff, Calm (--curves all takes them)";
    assert!(noted.contains(driven), "{noted}");
    let examples = npz::load(&path).unwrap().examples;
    assert_eq!(examples.curve_names, ["puff", "smile", "Wink"]);
    assert_eq!(examples.curves, [1.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
    // Puff at its default, and the shape keys without animation.
    let rest = [[0.0, 0.0, 0.0], [1.05, 0.0, 0.0], [1.05, 0.025, 1.0], [0.0, 0.0, 1.0]];
    near(examples.rest.as_flattened(), rest.as_flattened());
    // Animated shape keys play: Grin and Puff in frame 2, where the head is upright.
    near(&examples.frame(0)[0], &[0.1, 0.0, 0.0]);
    near(&examples.frame(0)[1], &[1.1, 0.0, 0.0]);
    near(&examples.frame(0)[2], &[1.05, 0.025, 1.0]);
    // In frame 3 the head nods: Tilt and Wink are on.
    let (sine, cosine) = (45.0_f64.to_radians().sin(), 45.0_f64.to_radians().cos());
    let tilt = 0.1 * 45.0_f64.to_radians();
    near(&examples.frame(1)[0], &[0.1, cosine * tilt, sine * tilt]);
    near(&examples.frame(1)[1], &[1.0, cosine * 0.1, sine * 0.1]);
    let maps = examples.pose(0)[0];
    near(maps.as_flattened(), &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
}

/// Turns of the head about x in all frames, and the values of the named curves. The skin of every frame must be that of
/// the closed form.
fn driven_frames(path: &Path, names: [&str; 3]) -> (Vec<f64>, [Vec<f64>; 3]) {
    let examples = npz::load(path).unwrap().examples;
    let column = |name: &str| examples.curve_names.iter().position(|own| own == name).unwrap();
    let columns = names.map(column);
    let mut turns = Vec::new();
    let mut values = [const { Vec::new() }; 3];
    for frame in 0..examples.frame_len() {
        let [_, y, z] = examples.pose(frame)[0];
        turns.push(z[1].atan2(y[1]));
        let own = columns.map(|column| examples.curves_of(frame)[column]);
        values.iter_mut().zip(own).for_each(|(values, value)| values.push(value));
    }
    (turns, values)
}

fn ends(values: &[f64]) -> [f64; 2] {
    [values.iter().copied().fold(9.0, f64::min), values.iter().copied().fold(-9.0, f64::max)]
}

#[test]
fn a_range_of_motion_turns_bones_within_limits_and_moves_keyed_properties() {
    let arguments = ["--range-of-motion", "--frames", "30"];
    let Some((output, path)) = driven("range", &arguments) else { return };
    let [said, _] = done(&output);
    assert!(said.contains("clips: Range of motion (1 to 30)"), "{said}");
    let (turns, [smile, puff, wink]) = driven_frames(&path, ["smile", "puff", "Wink"]);
    // Limits of the bone. Keys go from 0 to 1, and a tenth more but at rest, which is 0.5 for Puff. Blender holds Wink
    // within its slider.
    near(&ends(&turns), &[-0.5, 0.8]);
    for (values, expected) in [(&smile, [0.0, 1.1]), (&puff, [-0.1, 1.1]), (&wink, [0.0, 1.0])] {
        near(&ends(values), &expected);
    }
    let examples = npz::load(&path).unwrap().examples;
    assert_eq!((examples.frame_len(), examples.curve_names.len()), (30, 3));
    for (frame, turn) in turns.iter().enumerate() {
        let (sine, cosine) = turn.sin_cos();
        // Tilt follows the bone. Shape keys stay within 0 and 1.
        let on = |value: f64| 0.1 * value.clamp(0.0, 1.0);
        let (tilt, wink) = (on(*turn), on(wink[frame]));
        near(&examples.frame(frame)[0], &[on(smile[frame]), cosine * tilt, sine * tilt]);
        let puff = 1.0 + on(puff[frame]);
        near(&examples.frame(frame)[1], &[puff, cosine * wink, sine * wink]);
    }
    // Each of the four moves alone in two or more frames.
    let rest = |x: &f64, at: f64| (x - at).abs() < 1e-6;
    let alone = (0..10).filter(|&frame| {
        let still = [
            rest(&turns[frame], 0.0),
            rest(&smile[frame], 0.0),
            rest(&puff[frame], 0.5),
            rest(&wink[frame], 0.0),
        ];
        still.iter().filter(|still| **still).count() == 3
    });
    assert!(alone.count() >= 8);
}

#[test]
fn a_range_of_motion_by_degrees_needs_no_keys() {
    let arguments = ["--range-of-motion", "--frames", "40", "--degrees", "20"];
    let Some((output, path)) = driven("degrees", &arguments) else { return };
    done(&output);
    let examples = npz::load(&path).unwrap().examples;
    let mut names = examples.curve_names.clone();
    names.sort();
    assert_eq!(names, ["Style", "Wink", "calm", "puff", "smile"]);
    let (_, values) = driven_frames(&path, ["Wink", "puff", "smile"]);
    values.iter().for_each(|values| near(&ends(values), &[0.0, 1.0]));
}

#[test]
fn frames_and_bones_can_be_chosen() {
    let arguments = ["--frames", "1:3:2", "--bones", "all"];
    let Some((output, path)) = export("chosen", "limb.blend", &arguments) else { return };
    done(&output);
    let Loaded { examples, clips, .. } = npz::load(&path).unwrap();
    assert_eq!(examples.skeleton.names, ["upper", "control", "lower"]);
    assert_eq!(examples.frame_len(), 2);
    assert_eq!(clips, [clip("RigAction", 0, 24.0, &[1, 3])]);
}

/// Makes a clip of numbered frames.
fn clip(name: &str, first: usize, fps: f64, numbers: &[i64]) -> Clip {
    let times = numbers.iter().map(|number| (number - numbers[0]) as f64 / fps).collect();
    Clip { name: name.to_owned(), first, times, numbers: Some(numbers.to_vec()) }
}

#[test]
fn meshes_are_joined_strips_are_clips_and_a_group_weighs() {
    let arguments = ["--importance", "Matters"];
    let Some((output, path)) = export("strips", "strips.blend", &arguments) else { return };
    let [said, noted] = done(&output);
    let words = "meshes: Limb, Sleeve\n  clips: Bend (1 to 3), Twist (5 to 6), Again (7 to 9)\n";
    assert!(said.contains(words), "{said}");
    for words in
        ["hidden in the viewport are left out: Hair, Scales", "of no strip are left out: 2 ("]
    {
        assert!(noted.contains(words), "{noted}");
    }
    assert!(!noted.contains("muted"), "{noted}");
    let Loaded { examples, clips, warnings } = npz::load(&path).unwrap();
    assert_eq!(warnings, []);
    let fps = 24.0 / f64::from(1.001_f32);
    let [bend, twist] = [clip("Bend", 0, fps, &[1, 2, 3]), clip("Twist", 3, fps, &[5, 6])];
    assert_eq!(clips, [bend, twist, clip("Again", 5, fps, &[7, 8, 9])]);
    assert_eq!(examples.ranges, [("Limb".to_owned(), 0..6), ("Sleeve".to_owned(), 6..10)]);
    assert_eq!(examples.space.unit, Some(0.1));
    let importance = examples.importance.as_ref().unwrap();
    let ratios: Vec<f64> = importance.iter().map(|number| number / importance[0]).collect();
    near(&ratios, &[1.0, 0.0, 0.0, 0.25, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    near(&examples.joint_weights.as_ref().unwrap()[2 * 6..], &[1.0, 0.0].repeat(4));
    // The sleeve is mirrored and its faces are flipped; it has no texture and no seam.
    near(&examples.rest[7], &[-0.2, 0.0, 0.0]);
    assert_eq!(examples.triangles[6..], [[6, 8, 7], [6, 9, 8]]);
    let surface = examples.surface();
    let uv = surface.uv().unwrap();
    let own: Vec<_> = (0..uv.len()).filter(|&copy| surface.copy_of(copy) >= 6).collect();
    assert!(own.len() == 4 && own.iter().all(|&copy| uv[copy] == [0.0; 2]));
    // Each strip plays its action: rotated by 90 degrees about the bone's y axis, which is z, x
    // becomes y.
    near(&examples.frame(2)[5], &[0.3, -0.5, 1.3]);
    near(&examples.frame(3)[5], &[0.3, 0.3, 1.5]);
    near(&examples.frame(4)[5], &[-0.3, 0.3, 1.5]);
    near(&examples.frame(4)[7], &[-0.2, 0.0, 0.0]);
    near(&examples.frame(5)[5], &[0.3, 0.3, 1.5]);
    near(&examples.frame(7)[5], &[0.3, -0.5, 1.3]);

    // One clip, held out or alone.
    let clip = Source { clips: &["Twist".to_owned()], ..Source::file(&path) };
    let Loaded { examples: alone, clips, .. } = load(&clip).unwrap();
    assert_eq!((alone.frame_len(), clips.len(), clips[0].number(0)), (2, 1, Some(5)));
    assert_eq!(alone.frame(1), examples.frame(4));
}

#[test]
fn muted_strips_are_left_out_and_named() {
    let fps = 24.0 / f64::from(1.001_f32);
    let all: Vec<i64> = (1..=10).collect();
    for (scene, silent, clip) in [
        // A muted strip, and the strip of a muted track.
        ("muted", "Twist, Again", clip("Bend", 0, fps, &[1, 2, 3])),
        ("off", "Bend, Twist, Again", clip("Scene", 0, fps, &all)),
    ] {
        let file = format!("{scene}.blend");
        let Some((output, path)) = export(scene, &file, &["--mesh", "Limb"]) else { return };
        let [said, noted] = done(&output);
        let words = format!("muted strips of the NLA are left out: {silent}\n");
        assert!(noted.contains(&words), "{said}{noted}");
        assert!(!noted.contains("actions that nothing plays"), "{noted}");
        assert_eq!(npz::load(&path).unwrap().clips, [clip]);
    }
}

#[test]
fn overlapping_strips_play_one_at_a_time_and_growing_modifiers_are_named() {
    let Some(python) = python() else { return };
    let arguments = ["--mesh", "Sleeve", "--mesh", "Limb"];
    let Some((output, path)) = export("muddled", "muddled.blend", &arguments) else { return };
    let [_, noted] = done(&output);
    assert!(
        noted.contains("strips that overlap play one at a time: Bend, Twist (--clips"),
        "{noted}"
    );
    let Loaded { examples, clips, .. } = npz::load(&path).unwrap();
    let fps = 24.0 / f64::from(1.001_f32);
    let again = clip("Again", 6, fps, &[7, 8, 9]);
    assert_eq!(clips, [clip("Bend", 0, fps, &[1, 2, 3]), clip("Twist", 3, fps, &[2, 3, 4]), again]);
    assert_eq!(examples.ranges[0].0, "Limb", "the scene's order");
    // The last frame of each strip, as without an overlap.
    near(&examples.frame(2)[5], &[0.3, -0.5, 1.3]);
    near(&examples.frame(5)[5], &[-0.3, 0.3, 1.5]);
    let strips = path.with_file_name("strips.blend");
    let muddled = path.with_file_name("muddled.blend");
    let none = path.with_file_name("none.npz");
    for (scene, arguments, words) in [
        (&muddled, &[][..], "frame 2: mesh Hair has 3 vertices, at rest 2: turn off the modifier"),
        (
            &muddled,
            &["--mesh", "Scales"],
            "frame 3: mesh Scales has other faces than at rest: turn",
        ),
        (&strips, &["--mesh", "Hair"], "hidden in the viewport: Hair: show what is to be written"),
        (&strips, &["--frames", "10:12"], "--frames 10:12: no strip of Rig is there (--clips one"),
        (
            &strips,
            &["--importance", "Face"],
            "has a vertex group Face, only: Matters, lower, upper",
        ),
    ] {
        let output = of(&python, scene, &none, arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{error}");
        assert!(!none.exists());
    }
    // The loader reports faults that the script cannot fix.
    done(&of(&python, &path.with_file_name("mirrored.blend"), &none, &["--mesh", "Limb"]));
    let error = npz::load(&none).unwrap_err().to_string();
    assert!(error.contains("in the rest pose, joint upper is mirrored"), "{error}");
}

/// A studio's rig: the export must equal the export from the time when the set was made, plus newer
/// fields.
#[test]
fn the_leg_is_exported_anew_as_it_was() {
    let Some(python) = python() else { return };
    let Some(scene) = models::shared("leg/leg.blend") else { return };
    let examples = Path::new(env!("CARGO_TARGET_TMPDIR")).join("blender-leg.npz");
    done(&of(&python, &scene, &examples, &[]));
    let Loaded { examples, clips, warnings } = npz::load(&examples).unwrap();
    assert_eq!(warnings, []);
    let numbers: Vec<i64> = (1..=122).collect();
    let stretch = clip("Stretch", 66, 30.0, &numbers[66..]);
    assert_eq!(clips, [clip("Walk Cycle", 0, 30.0, &numbers[..66]), stretch]);
    let before = npz::load(&scene.with_extension("npz")).unwrap().examples;
    assert_eq!(examples.triangles, before.triangles);
    let f32s =
        |all: &[[f64; 3]]| -> Vec<f32> { all.as_flattened().iter().map(|x| *x as f32).collect() };
    assert!(f32s(&examples.rest) == f32s(&before.rest));
    assert!(f32s(&examples.vertices) == f32s(&before.vertices));
    let maps = |examples: &Examples| examples.transforms.as_flattened().as_flattened().to_vec();
    near(&maps(&examples), &maps(&before));
    assert_eq!(examples.surface().engine_len(), 4164, "with its seams");
}

/// Animators exchange the armature alone. Blender's FBX then contains no rest pose, but the current
/// frame.
#[test]
fn an_armature_alone_plays_on_its_character() {
    let Some(python) = python() else { return };
    let Some(scene) = models::shared("leg/leg.blend") else { return };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("blender-joints");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let paths = [scene.to_str().unwrap(), folder.to_str().unwrap()];
    let made = run(&python, "tests/blender/joints.py", &paths);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let mesh = folder.join("leg.npz");
    done(&of(&python, &scene, &mesh, &[]));
    let Loaded { examples: character, clips: own, .. } = npz::load(&mesh).unwrap();
    for (file, warnings) in
        [("joints.fbx", vec![Warning::RestOfCharacter]), ("joints.glb", Vec::new())]
    {
        let played = load_motion(&Source::file(&folder.join(file)), Some(&mesh)).unwrap();
        assert_eq!(played.warnings, warnings, "{file}");
        assert_eq!(played.clips.len(), own.len(), "{file}");
        for clip in &own {
            let found = played.clips.iter().find(|found| found.name.ends_with(&clip.name)).unwrap();
            assert_eq!(found.times.len(), clip.times.len(), "{file}");
            for frame in 0..clip.times.len() {
                let [found, expected] =
                    [played.examples.pose(found.first + frame), character.pose(clip.first + frame)]
                        .map(|pose| pose.as_flattened().as_flattened().to_vec());
                let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0, f64::max);
                assert!(apart < 1e-4, "{file}, {}, {frame}: {apart}", clip.name);
            }
        }
    }
}

#[test]
fn missing_parts_of_a_scene_are_named_and_nothing_is_written() {
    for (test, arguments, words) in [
        ("mesh", ["--mesh", "Arm"], "there is no mesh Arm, only: Limb"),
        ("armature", ["--armature", "Limb"], "there is no armature Limb, only: Rig"),
        ("frames", ["--frames", "9:1"], "--frames 9:1: expected FIRST:LAST or FIRST:LAST:STEP"),
        ("option", ["--curves", "some"], "argument --curves: invalid choice: 'some'"),
    ] {
        let Some((output, path)) = export(test, "limb.blend", &arguments) else { return };
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{error}");
        assert!(error.lines().count() == 1 && !path.exists(), "{error}");
    }
}
