//! The Blender script, run in the `bpy` package: what it exports is what the scene was made of.

#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

use sinew_trainer::examples::{Loaded, Source, Warning, load, npz};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Gives the Python that has `bpy`; none where `cargo xtask test` found that it does not install.
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

/// Makes the scene and exports it; gives the script's output and where the examples should be.
fn export(test: &str, more: &[&str]) -> Option<(Output, PathBuf)> {
    let python = python()?;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("blender-{test}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let [scene, examples] = ["limb.blend", "limb.npz"].map(|name| folder.join(name));
    let made = run(&python, "tests/blender/scene.py", &[scene.to_str().unwrap()]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let mut arguments = vec!["--blend", scene.to_str().unwrap(), examples.to_str().unwrap()];
    arguments.extend(more);
    Some((run(&python, "blender_export.py", &arguments), examples))
}

fn near(found: &[f64], expected: &[f64]) {
    let far = found.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-6);
    assert!(!far && found.len() == expected.len(), "{found:?}, expected {expected:?}");
}

#[test]
fn a_scene_becomes_the_examples_that_it_shows() {
    let Some((output, path)) = export("scene", &[]) else { return };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let words = "6 vertices, 2 joints, 3 frames";
    assert!(String::from_utf8_lossy(&output.stdout).contains(words));
    let Loaded { examples, warnings, .. } = npz::load(&path).unwrap();
    assert_eq!(warnings, []);
    // A quad, a triangle, and three triangles for the face of five corners.
    assert_eq!((examples.vertex_len(), examples.triangles.len()), (6, 2 + 1 + 3));
    assert_eq!(examples.skeleton.names, ["upper", "lower"]);
    assert_eq!(examples.skeleton.parents, [None, Some(0)]);
    near(&examples.skeleton.rest[1].map(|row| row[3]), &[0.0, 0.0, 1.0]);
    near(&examples.rest[5], &[0.3, 0.3, 1.5]);
    // A bone's own x stays x: by 90 degrees about it at (0, 0, 1), y becomes z and z becomes -y.
    let bent = examples.pose(2)[1];
    near(&bent[0], &[1.0, 0.0, 0.0, 0.0]);
    near(&bent[1], &[0.0, 0.0, -1.0, 1.0]);
    near(&bent[2], &[0.0, 1.0, 0.0, 1.0]);
    near(&examples.frame(2)[5], &[0.3, -0.5, 1.3]);
    near(&examples.frame(2)[0], &[0.2, 0.0, 0.5]);
    near(&examples.frame(1)[0], &[0.15, 0.0, 0.5]);
    // Vertices 2, 3 and 4 have two places in the texture each.
    let surface = examples.surface();
    let uv = surface.uv().unwrap().iter().enumerate();
    let mut found: Vec<_> = uv.map(|(copy, uv)| (surface.copy_of(copy), *uv)).collect();
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    // Copies that differ in their tangents alone.
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

/// Blender's own exporter writes other axes and units, and every bone.
#[test]
fn the_same_scene_as_fbx_moves_the_same_joints() {
    let Some((output, path)) = export("fbx", &[]) else { return };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let scene = path.with_extension("fbx");
    let source = Source { targets: Some(&path), ..Source::file(&scene) };
    let Loaded { examples, warnings, .. } = load(&source).unwrap();
    let how = "(x, -z, y) x 0.01".to_owned();
    assert_eq!(warnings, [Warning::Moved { what: "joints", how }]);
    assert_eq!(examples.skeleton.names, ["upper", "control", "lower"]);
    let script = npz::load(&path).unwrap().examples;
    assert_eq!(examples.rest, script.rest);
    for frame in 0..3 {
        for (joint, other) in [(0, 0), (2, 1)] {
            let [found, expected] = [examples.pose(frame)[joint], script.pose(frame)[other]];
            near(found.as_flattened(), expected.as_flattened());
        }
    }
    // Alone the scene shows what the script saw, in its own space: skin and shape key.
    let alone = load(&Source::file(&scene)).unwrap().examples;
    let moved = |&[x, y, z]: &[f64; 3]| [0.01 * x, -0.01 * z, 0.01 * y];
    for frame in 0..3 {
        let found: Vec<_> = alone.frame(frame).iter().map(moved).collect();
        near(found.as_flattened(), script.frame(frame).as_flattened());
    }
}

#[test]
fn frames_and_bones_can_be_chosen() {
    let Some((output, path)) = export("chosen", &["--frames", "1:3:2", "--bones", "all"]) else {
        return;
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let examples = npz::load(&path).unwrap().examples;
    assert_eq!(examples.skeleton.names, ["upper", "control", "lower"]);
    assert_eq!(examples.frame_len(), 2);
}

#[test]
fn what_the_scene_lacks_is_named_and_nothing_is_written() {
    for (test, arguments, words) in [
        ("mesh", ["--mesh", "Arm"], "there is no mesh Arm, only: Limb"),
        ("armature", ["--armature", "Limb"], "there is no armature Limb, only: Rig"),
        ("frames", ["--frames", "9:1"], "--frames 9:1: expected FIRST:LAST or FIRST:LAST:STEP"),
    ] {
        let Some((output, path)) = export(test, &arguments) else { return };
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{error}");
        assert!(!path.exists());
    }
}
