//! Bad input and bad usage: one line names the place, and nothing is written. Outputs: complete or
//! absent, and never in place of an input.

use super::common::{Folder, Set};
use serde_json::json;
use std::fs;

/// Damages the demo's examples and trains on them; expects an error with the place of the fault.
#[track_caller]
fn refused(test: &str, spoil: impl FnOnce(&mut Set), expected: &str) {
    let folder = Folder::with_demo(test);
    let mut set = Set::demo();
    spoil(&mut set);
    set.write(&folder.path("bad.npz"));
    let before = folder.list();
    let command = "train bad.npz --proxies 2 --record record.json -o";
    assert_eq!(folder.sinew(&format!("{command} new.sinew")).failed(), expected);
    let model = folder.read("demo.sinew");
    assert_eq!(folder.sinew(&format!("{command} demo.sinew")).failed(), expected);
    assert!(folder.read("demo.sinew") == model, "the model that was there is kept");
    assert_eq!(folder.list(), before, "nothing new, whole or in part");
}

fn real(set: &mut Set, array: &str, place: usize, number: f64) {
    set.reals.get_mut(array).unwrap().1[place] = number;
}

#[test]
fn examples_that_are_not_finite_are_refused_by_array_frame_and_place() {
    let posed = |number| {
        move |set: &mut Set| {
            let place = 3 * (7 * set.vertex_len() + 11) + 1;
            real(set, "vertices", place, number);
        }
    };
    let expected = "bad.npz: frame 7: array vertices is not finite at vertex 11";
    refused("nan", posed(f64::NAN), expected);
    refused("infinite", posed(f64::NEG_INFINITY), expected);
    let expected = "bad.npz: array rest is not finite at vertex 4";
    refused("nan-rest", |set| real(set, "rest", 3 * 4, f64::NAN), expected);
    let joint = |set: &mut Set| {
        let place = 16 * (9 * set.joint_len() + 1) + 3;
        real(set, "bone_transforms", place, f64::INFINITY);
    };
    let expected = "bad.npz: frame 9: array bone_transforms is not finite at joint clavicle";
    refused("infinite-joint", joint, expected);
}

#[test]
fn counts_that_disagree_are_refused_by_array() {
    let expected = "bad.npz: vertices has 52 frames, bone_transforms has 51";
    refused("frames", |set| set.cut("bone_transforms", 51), expected);
    let v = Set::demo().vertex_len();
    let expected = format!("bad.npz: rest has {} vertices, vertices has {v}", v - 1);
    // Faces that refer to a missing vertex would be reported first.
    let fewer = |set: &mut Set| {
        set.cut("rest", v as u64 - 1);
        let (shape, corners) = set.wholes.get_mut("tris").unwrap();
        (shape[0], *corners) = (1, vec![0, 1, 2]);
    };
    refused("vertices", fewer, &expected);
}

#[test]
fn joints_that_form_no_tree_are_refused_by_name() {
    let expected = "bad.npz: joints are their own ancestors: clavicle -> upper_arm -> clavicle";
    refused("cycle", |set| set.json["bone_parents"][1] = json!(2), expected);
    let expected = "bad.npz: joint clavicle has parent 7, which does not exist";
    refused("parent", |set| set.json["bone_parents"][1] = json!(7), expected);
    let expected = "bad.npz: joint clavicle has parent tail, which does not exist";
    refused("parent-name", |set| set.json["bone_parents"][1] = json!("tail"), expected);
    let expected = "bad.npz: array bone_parents is missing";
    let parentless = |set: &mut Set| {
        set.json.as_object_mut().unwrap().remove("bone_parents");
    };
    refused("parentless", parentless, expected);
}

#[test]
fn mirrored_and_flat_matrices_are_refused_by_frame_and_joint() {
    fn scaled(set: &mut Set, factor: f64) {
        let place = 16 * (5 * set.joint_len() + 6);
        for axis in [0, 1, 2] {
            set.reals.get_mut("bone_transforms").unwrap().1[place + axis] *= factor;
        }
    }
    let expected = "bad.npz: frame 5: joint hand is scaled to 0: leave the frames out in which it is \
                    hidden, or remove its scale keys";
    refused("flat", |set: &mut Set| scaled(set, 0.0), expected);
    let expected = "bad.npz: frame 5: joint hand is mirrored: apply the scale of the armature and of \
                    its parents (in Blender Ctrl+A) and export again";
    refused("turned", |set: &mut Set| scaled(set, -1.0), expected);
    let mirrored = |set: &mut Set| {
        for axis in [0, 1, 2] {
            set.reals.get_mut("joint_world_rest").unwrap().1[axis] *= -1.0;
        }
    };
    let expected = "bad.npz: in the rest pose, joint chest is mirrored: apply the scale of the \
                    armature and of its parents (in Blender Ctrl+A) and export again";
    refused("mirrored", mirrored, expected);
}

#[test]
fn too_few_poses_and_meshes_without_area_are_refused() {
    let few = |set: &mut Set| {
        for code in set.wholes.get_mut("split").unwrap().1.iter_mut().skip(5) {
            *code = 1;
        }
    };
    refused("few", few, "bad.npz: the fit needs 6 training poses, found 5");
    let flat = |set: &mut Set| set.reals.get_mut("rest").unwrap().1.fill(1.0);
    let triangles = Set::demo().wholes["tris"].0[0];
    refused("flat", flat, &format!("bad.npz: none of the {triangles} rest triangles has an area"));
}

#[test]
fn files_given_by_mistake_are_refused_by_name() {
    let folder = Folder::with_demo("mistakes");
    fs::write(folder.path("text.npz"), "no archive").unwrap();
    fs::create_dir(folder.path("inner")).unwrap();
    let before = folder.list();
    for (examples, expected) in [
        ("none.npz", "none.npz: cannot be read: "),
        (
            "text.npz",
            "text.npz: is no whole .npz archive: its 10 bytes do not end with the archive's directory",
        ),
        ("demo.json", "demo.json: describes examples, expected the .npz file beside it"),
        (
            "new.json",
            "new.json: there is no such file; --json prints its results and takes no name",
        ),
        (
            "demo.sinew",
            "demo.sinew: is a baked model, expected examples: commands take the model first",
        ),
        ("inner", "inner: is a folder, expected a file"),
    ] {
        let train = folder.sinew(&format!("train {examples} -o new.sinew")).failed();
        let eval = folder.sinew(&format!("eval demo.sinew {examples}")).failed();
        assert!(train.starts_with(expected) && eval == train, "{train}\n{eval}");
        assert_eq!(train.matches(examples).count(), 1, "{train}");
    }
    for (model, expected) in [
        ("none.sinew", "cannot read none.sinew: "),
        ("inner", "cannot read inner: it is a folder"),
        ("text.npz", "text.npz: "),
        ("demo.npz", "demo.npz: "),
    ] {
        let inspect = folder.sinew(&format!("inspect {model}")).failed();
        let eval = folder.sinew(&format!("eval {model} demo.npz")).failed();
        assert!(inspect.starts_with(expected) && eval.starts_with(expected), "{inspect}\n{eval}");
    }
    assert_eq!(folder.list(), before);
}

#[test]
fn models_that_are_damaged_or_of_another_character_are_refused() {
    let folder = Folder::with_demo("models");
    let model = folder.read("demo.sinew");
    let lengths = (0..model.len()).step_by(model.len() / 12).chain([1, 5, 40, model.len() - 1]);
    let damaged = |place: usize| {
        let mut bytes = model.clone();
        bytes[place] ^= 0x40;
        bytes
    };
    let bad = lengths
        .map(|len| model[..len].to_vec())
        .chain((0..model.len()).step_by(model.len() / 12).map(damaged))
        .chain([[model.as_slice(), &[0]].concat()]);
    for bytes in bad {
        fs::write(folder.path("bad.sinew"), bytes).unwrap();
        let line = folder.sinew("inspect bad.sinew").failed();
        assert!(line.starts_with("bad.sinew: "), "{line}");
        let line = folder.sinew("eval bad.sinew demo.npz --write-vertices out.npy").failed();
        assert!(line.starts_with("bad.sinew: the model is refused: "), "{line}");
    }
    let mut other = Set::demo();
    other.json["bone_names"][6] = json!("paw");
    other.write(&folder.path("other.npz"));
    let line = folder.sinew("eval demo.sinew other.npz --write-vertices out.npy").failed();
    assert_eq!(line, "demo.sinew: joint 6 is called hand in the model, paw in the examples");
    let line = folder.sinew("eval demo.sinew demo.npz --split extreme").failed();
    let expected = "demo.npz: the examples have no extreme frame: 40 training, 12 held-out, 0 \
                    extreme frames";
    assert_eq!(line, expected);
    assert!(!folder.path("out.npy").exists());
}

#[test]
fn arguments_out_of_range_are_bad_usage() {
    let folder = Folder::with_demo("usage");
    let before = folder.list();
    for arguments in [
        "--helpers 0",
        "--helpers -1",
        "--helpers 100000",
        "--budget 0",
        "--budget -1",
        "--budget 3q",
        "--budget 3TB",
        "--budget 1e3",
        "--max-error 0",
        "--max-error -1",
        "--max-error nan",
        "--helpers 2 --max-error 1",
        "--influences 0",
        "--influences 13",
        "--hold-out 0",
        "--hold-out 1",
        "--hold-out -0.5",
        "--hold-out nan",
        "--predictor magic",
    ] {
        let run = folder.sinew(&format!("train demo.npz -o new.sinew {arguments}"));
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{arguments}: {}", run.err);
        let option = arguments.split(' ').next().unwrap();
        assert!(run.err.starts_with("error: ") && run.err.contains(option), "{}", run.err);
        // Errors about numbers state the permitted range.
        let ranges = ["--helpers 0", "--helpers -1", "--helpers 100000"];
        let expected = "expected a whole number from 1 to ";
        assert_eq!(
            run.err.contains(expected),
            ranges.contains(&arguments) || option == "--influences",
            "{}",
            run.err
        );
        let units = run.err.contains("kB, KiB, MB or MiB");
        assert_eq!(units, option == "--budget", "{}", run.err);
    }
    for arguments in ["--poses 0", "--held-out 0", "--vertices 0", "--vertices many"] {
        assert_eq!(folder.sinew(&format!("demo {arguments}")).code, Some(2), "{arguments}");
    }
    let line = folder.sinew("train demo.npz -o new.sinew --helpers 1000").failed();
    let triangles = Set::demo().wholes["tris"].0[0];
    let expected =
        format!("--helpers: demo.npz has {triangles} triangles, 1000 helpers are too many");
    assert_eq!(line, expected);
    let line = folder.sinew("demo --vertices 90000000").failed();
    assert!(line.contains("expected at most"), "{line}");
    assert_eq!(folder.list(), before);
}

#[test]
fn files_are_recognised_by_their_content() {
    let folder = Folder::with_demo("contents");
    for (name, bytes) in [
        ("empty.glb", &b""[..]),
        ("scene.glb", b"Kaydara FBX Binary  \0\x1a\0"),
        ("scene.fbx", b"glTF\x02\0\0\0"),
        ("set.fbx", b"PK\x03\x04"),
    ] {
        fs::write(folder.path(name), bytes).unwrap();
    }
    fs::copy(folder.path("demo.sinew"), folder.path("model.npz")).unwrap();
    let before = folder.list();
    for (examples, expected) in [
        ("empty.glb", "empty.glb: is empty"),
        ("scene.glb", "scene.glb: holds what a .fbx file holds: give it that ending"),
        ("scene.fbx", "scene.fbx: holds what a .glb file holds: give it that ending"),
        ("set.fbx", "set.fbx: holds what a .npz file holds: give it that ending"),
        (
            "model.npz",
            "model.npz: is a baked model, expected examples: commands take the model first",
        ),
    ] {
        assert_eq!(folder.sinew(&format!("train {examples} -o new.sinew")).failed(), expected);
    }
    let line = folder.sinew("eval demo.npz demo.sinew").failed();
    let expected =
        "demo.npz: holds what a .npz file holds, expected a model, which commands take first";
    assert_eq!(line, expected);
    let line = folder.sinew("export demo.sinew --clip demo.npz -o out.fbx").failed();
    assert_eq!(line, "out.fbx: expected a file that ends in .glb or .usda");
    assert_eq!(folder.list(), before);
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_work() {
    let folder = Folder::with_demo("outputs");
    fs::create_dir(folder.path("inner")).unwrap();
    let (before, examples) = (folder.list(), folder.read("demo.npz"));
    let train = "train demo.npz -o";
    let eval = "eval demo.sinew demo.npz --write-vertices";
    for (command, expected) in [
        (format!("{train} no/new.sinew"), "cannot write no/new.sinew: there is no folder no"),
        (format!("{train} inner"), "cannot write inner: it is a folder"),
        (format!("{train} new/"), "cannot write new/: it is a folder"),
        (format!("{train} demo.npz"), "cannot write demo.npz: it is an input"),
        (format!("{train} inner/../demo.json"), "cannot write inner/../demo.json: it is an input"),
        (
            format!("{train} new.glb"),
            "cannot write new.glb: a model is no .glb file, name it .sinew",
        ),
        (
            "report demo.sinew demo.npz -o new.PDF".to_owned(),
            "cannot write new.PDF: a report is no .pdf file, name it .html",
        ),
        (format!("{train} new --record demo.npz"), "cannot write demo.npz: it is an input"),
        (format!("{train} new --record no/r"), "cannot write no/r: there is no folder no"),
        (format!("{train} new --record ./new"), "cannot write new: model and record are one file"),
        (format!("{eval} no/out.npy"), "cannot write no/out.npy: there is no folder no"),
        (format!("{eval} demo.sinew"), "cannot write demo.sinew: it is an input"),
        (format!("{eval} demo.npz"), "cannot write demo.npz: it is an input"),
    ] {
        assert_eq!(folder.sinew(&command).failed(), expected);
        assert_eq!(folder.list(), before, "{command}");
    }
    assert!(folder.read("demo.npz") == examples);
    let line = folder.sinew("demo -o demo.npz").failed();
    assert_eq!(line, "cannot make the folder demo.npz: it is a file");
    let line = folder.sinew("export-demo demo.npz").failed();
    assert_eq!(line, "cannot make the folder demo.npz: it is a file");
}

#[test]
fn a_closed_pipe_is_no_failure_and_no_panic() {
    let folder = Folder::with_demo("pipe");
    for arguments in ["inspect demo.sinew", "inspect demo.sinew --json", "eval demo.sinew demo.npz"]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = folder.command(arguments);
        let run = command.stdout(writer).stderr(std::process::Stdio::piped()).spawn().unwrap();
        let output = run.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    }
}

/// A file that may not grow simulates a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_everything_as_it_was() {
    let folder = Folder::with_demo("full");
    fs::write(folder.path("record.json"), "old").unwrap();
    let before: Vec<_> = folder.list().into_iter().map(|name| folder.read(&name)).collect();
    let sinew = env!("CARGO_BIN_EXE_sinew");
    // Enough for the record, which is written first, but not for the model.
    for (blocks, arguments, named) in [
        (40, "train demo.npz -o demo.sinew --record record.json --proxies 4", "demo.sinew"),
        (1, "train demo.npz -o demo.sinew --record record.json --proxies 4", "record.json"),
        (1, "eval demo.sinew demo.npz --write-vertices demo.npy", "demo.npy"),
    ] {
        let mut command = std::process::Command::new("sh");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec '{sinew}' {arguments}");
        command.args(["-c", &script]).current_dir(folder.path(""));
        let line = folder.run(command).failed();
        assert!(line.starts_with(&format!("cannot write {named}: ")), "{line}");
        let after: Vec<_> = folder.list().into_iter().map(|name| folder.read(&name)).collect();
        assert!(after == before, "{:?}", folder.list());
    }
}
