//! `sinew poses`: its file, its ranges and its refusals.

use super::common::{Folder, Set, read_array, write_arrays};
use nalgebra::Matrix4;
use serde_json::json;
use sinew_trainer::examples::{Examples, PoseRequest, npz, sample_poses};
use std::fs;
use zip::{ZipArchive, ZipWriter};

/// Adds the meshes to `poses.npz` as a program would, and returns the examples. Saves them as `train.npz`.
fn with_meshes(folder: &Folder, frames: u64) -> Examples {
    let rest = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let meshes: Vec<f64> = rest.repeat(frames as usize);
    write_arrays(
        &folder.path("meshes.npz"),
        &[("rest", &[3, 3], &rest[..]), ("vertices", &[frames, 3, 3], &meshes)],
    );
    write_arrays(&folder.path("faces.npz"), &[("tris", &[1, 3], &[0_i64, 1, 2][..])]);
    let mut joined = ZipWriter::new(fs::File::create(folder.path("train.npz")).unwrap());
    for name in ["poses.npz", "meshes.npz", "faces.npz"] {
        let mut own = ZipArchive::new(fs::File::open(folder.path(name)).unwrap()).unwrap();
        for index in 0..own.len() {
            joined.raw_copy_file(own.by_index_raw(index).unwrap()).unwrap();
        }
    }
    joined.finish().unwrap();
    npz::load(&folder.path("train.npz")).unwrap().examples
}

#[test]
fn training_reads_sampled_poses_once_they_have_meshes() {
    let folder = Folder::with_demo("poses");
    let found = folder.sinew("poses demo.npz -o poses.npz --frames 24 --json").json();
    assert_eq!((found["frames"].as_u64(), found["joints"].as_u64()), (Some(24), Some(6)));
    let text = folder.sinew("poses demo.npz -o again.npz --frames 24").done().out;
    assert!(text.starts_with("6 joints of 7 move, and 0 curves: "), "{text}");
    assert_eq!(folder.read("poses.npz"), folder.read("again.npz"), "the same seed");
    folder.sinew("poses demo.npz -o other.npz --frames 24 --seed 1").done();
    assert_ne!(folder.read("poses.npz"), folder.read("other.npz"), "another seed");
    let sampled = fs::File::open(folder.path("poses.npz")).unwrap();
    let sampled = ZipArchive::new(sampled).unwrap();
    let mut names: Vec<String> =
        sampled.file_names().map(|name| name.unwrap().into_owned()).collect();
    names.sort();
    let arrays =
        ["bone_names", "bone_parents", "bone_transforms", "inverse_binds", "joint_world_rest"];
    assert_eq!(names, arrays.map(|name| format!("{name}.npy")));
    with_meshes(&folder, 24);
    let text = folder.sinew("check train.npz -q").done().out;
    assert!(text.starts_with("3 vertices, 1 triangles, 7 joints; 24 training"), "{text}");
}

#[test]
fn the_file_holds_the_rig_and_the_poses_that_the_options_ask_for() {
    let folder = Folder::with_demo("poses-file");
    let mut set = Set::demo();
    let len = set.reals["bone_transforms"].0[0];
    set.json["curve_names"] = json!(["flex", "puff"]);
    set.reals.insert("curves", (vec![len, 2], (0..2 * len).map(|at| at as f64 / 64.0).collect()));
    set.write(&folder.path("rig.npz"));
    let rig = npz::load(&folder.path("rig.npz")).unwrap().examples;
    let request = PoseRequest { frames: 24, ..PoseRequest::default() };
    for (options, request) in [
        ("", request),
        ("--seed 1", PoseRequest { seed: 1, ..request }),
        ("--degrees 20", PoseRequest { degrees: Some(20.0), ..request }),
    ] {
        folder.sinew(&format!("poses rig.npz -q -o poses.npz --frames 24 {options}")).done();
        let found = with_meshes(&folder, 24);
        let expected = sample_poses(&rig, &request).unwrap();
        assert_eq!(found.skeleton.names, rig.skeleton.names);
        assert_eq!(found.skeleton.parents, rig.skeleton.parents);
        near(found.skeleton.rest.as_flattened(), rig.skeleton.rest.as_flattened());
        near(found.transforms.as_flattened(), expected.transforms.as_flattened());
        assert_eq!((&found.curve_names, &found.curves), (&rig.curve_names, &expected.curves));
    }
    let file = folder.read("poses.npz");
    let [rest, inverses] =
        ["joint_world_rest", "inverse_binds"].map(|name| read_array::<f64>(&file, name));
    assert_eq!((&rest.0, &inverses.0), (&vec![7, 4, 4], &vec![7, 4, 4]));
    for (rest, inverse) in rest.1.chunks_exact(16).zip(inverses.1.chunks_exact(16)) {
        let [rest, inverse] = [rest, inverse].map(Matrix4::from_row_slice);
        assert!((inverse * rest - Matrix4::identity()).amax() < 1e-12, "{rest} {inverse}");
    }
}

#[track_caller]
fn near(found: &[[f64; 4]], expected: &[[f64; 4]]) {
    let (found, expected) = (found.as_flattened(), expected.as_flattened());
    let far = found.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-9);
    assert!(!far && found.len() == expected.len(), "{found:?}, expected {expected:?}");
}

#[test]
fn a_rig_without_ranges_needs_degrees() {
    let folder = Folder::with_demo("poses-still");
    let mut still = Set::demo();
    let (shape, numbers) = still.reals.get_mut("bone_transforms").unwrap();
    let (frames, joints) = (shape[0] as usize, shape[1] as usize);
    let identity = |at: usize| f64::from(u8::from((at % 16).is_multiple_of(5)));
    *numbers = (0..16 * frames * joints).map(identity).collect();
    still.write(&folder.path("still.npz"));
    let line = folder.sinew("poses still.npz -q -o poses.npz").failed();
    assert_eq!(
        line,
        "still.npz: its training frames move no joint and no curve, so its ranges are unknown: give --degrees N, or \
         clips that show the ranges"
    );
    assert!(!folder.path("poses.npz").exists());
    folder.sinew("poses still.npz -q -o poses.npz --degrees 40").done();
    // The same rig as a scene, with and without its clips.
    folder.sinew("export-demo rig --vertices 300 --poses 20 --held-out 5").done();
    folder.sinew("poses rig/demo.glb -q -o by-clips.npz").done();
    let mut scene = folder.read("rig/demo.glb");
    let animations = scene.windows(12).position(|bytes| bytes == b"\"animations\"").unwrap();
    scene[animations + 1] = b'_';
    fs::write(folder.path("still.glb"), scene).unwrap();
    let line = folder.sinew("poses still.glb -q -o none.npz").failed();
    assert!(line.starts_with("still.glb: ") && line.contains("give --degrees N"), "{line}");
    folder.sinew("poses still.glb -q -o by-degrees.npz --degrees 40").done();
    for (arguments, message) in [
        ("demo.npz -o poses.txt", "poses.txt: expected a file that ends in .npz"),
        ("demo.npz -o demo.npz", "cannot write demo.npz: it is an input"),
        (
            "none.npz -o poses.npz",
            "none.npz: cannot be read: No such file or directory (os error 2)",
        ),
    ] {
        assert_eq!(folder.sinew(&format!("poses {arguments}")).failed(), message);
    }
    let refused = folder.sinew("poses demo.npz -o poses.npz --degrees 200");
    assert_eq!(refused.code, Some(2));
    assert!(refused.err.contains("expected a number above 0 to 180 degrees"), "{}", refused.err);
}
