//! Skins and spaces on the command line.

use super::common::{Folder, Set};
use super::export::write_obj;
use super::{TRAIN, number};
use serde_json::{Value, json};
use std::fs;

/// Axes and unit of the demo, as options.
const STATED: &str = "--up y --forward z --unit 1";
const UNREAL: &str = "--to-up z --to-forward x --to-hand left --to-unit 0.01";

#[test]
fn further_meshes_become_skins_of_the_file() {
    let folder = Folder::with_demo("skins");
    write_obj(&folder, "lod1.obj", 1.0);
    write_obj(&folder, "lod2.obj", 1.0);
    let train = format!("{TRAIN} --also lod1.obj --also lod2.obj --record record.json");
    let text = folder.sinew(&train).done().out;
    assert!(text.contains("transferred") && text.contains("\nlod2 "), "{text}");
    let record = folder.json("record.json");
    let names = |list: &Value| -> Vec<String> {
        let list = list.as_array().unwrap().iter();
        list.map(|one| one["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&record["levels"]), ["lod1", "lod2"]);
    assert_eq!(record["meshes"], json!({ "also": ["lod1.obj", "lod2.obj"], "no_skin": false }));
    let inputs = record["inputs"].as_array().unwrap().iter().map(|input| &input["file"]);
    assert!(inputs.eq(["demo.npz", "demo.json", "lod1.obj", "lod2.obj"]));
    let found = folder.sinew("inspect new.sinew --json").json();
    assert_eq!(names(&found["skins"]), ["skin", "lod1", "lod2"]);
    let text = folder.sinew("inspect new.sinew").done().out;
    let (_, skin) = text.split_once("skin \"lod1\", part 2\n").unwrap();
    let row = |label: &str| {
        let line = skin.lines().find_map(|line| line.trim_start().strip_prefix(label));
        line.unwrap_or_else(|| panic!("{label}: {text}")).trim()
    };
    assert_eq!(row("vertices"), Set::demo().vertex_len().to_string());
    assert_eq!(["influences a vertex", "tangents"].map(row), ["4", "no"]);
    assert_eq!(row("follows"), "envelope \"envelope\"");
    assert!(text.contains("rest_positions"), "{text}");
    // The mesh is unchanged.
    let measured = |skin: &str| {
        number(&folder.sinew(&format!("eval new.sinew demo.npz --json {skin}")).json()["rms"])
    };
    let own = measured("");
    assert_eq!(measured("--skin skin"), own);
    assert!((measured("--skin lod2") / own - 1.0).abs() < 0.1);
    folder.sinew("export new.sinew --clip demo.npz --skin lod1 -o out.glb").done();
    let glb = gltf::Gltf::from_slice(&folder.read("out.glb")).unwrap();
    assert_eq!(glb.meshes().next().unwrap().name(), Some("lod1"));
    folder.sinew("report new.sinew demo.npz --skin lod1 --quick -o page.html").done();
}

#[test]
fn a_palette_alone_has_no_skin_to_measure() {
    let folder = Folder::with_demo("palette");
    folder.sinew(&format!("{TRAIN} --no-skin")).done();
    let found = folder.sinew("inspect new.sinew --json").json();
    assert_eq!(
        (&found["skins"], &found["parts"]),
        (&json!([]), &json!([{ "kind": "envelope" }, { "kind": "record" }]))
    );
    let expected = "new.sinew: the model holds a palette alone, without a skin to measure or to play: train one \
                    without --no-skin for that";
    for command in [
        "eval new.sinew demo.npz",
        "report new.sinew demo.npz -o page.html",
        "export new.sinew --clip demo.npz -o out.glb",
    ] {
        assert_eq!(folder.sinew(command).failed(), expected);
    }
    let expected = "the model holds no skin called lod1; it has: skin";
    let line = folder.sinew("eval demo.sinew demo.npz --skin lod1").failed();
    assert_eq!(line, format!("demo.sinew: {expected}"));
    let run = folder.sinew(&format!("{TRAIN} --no-skin --also lod1.obj"));
    assert!(run.code == Some(2) && run.err.contains("--no-skin"), "{}", run.err);
}

#[test]
fn skins_that_cannot_be_are_refused_before_anything_is_written() {
    let folder = Folder::with_demo("skins-refused");
    write_obj(&folder, "skin.obj", 1.0);
    write_obj(&folder, "far.obj", 1e6);
    let before = folder.list();
    for (also, expected) in [
        (
            "--also skin.obj",
            "skin.obj: its skin would be called skin, as that of the examples' own mesh",
        ),
        (
            "--also far.obj --also far.obj",
            "far.obj: its skin would be called far, as that of far.obj",
        ),
        ("--also far.obj", "mesh far is "),
        ("--also none.obj", "none.obj: cannot be read: "),
    ] {
        let line = folder.sinew(&format!("{TRAIN} {also}")).failed();
        assert!(line.starts_with(expected), "{line}");
        assert_eq!(folder.list(), before);
    }
}

#[test]
fn a_model_for_an_engine_has_the_errors_of_one_in_the_examples_space() {
    let folder = Folder::with_demo("space");
    write_obj(&folder, "lod1.obj", 1.0);
    let record = folder.sinew(&format!("{TRAIN} --predictor kernel {STATED} --json")).json();
    let own = json!({ "up": "y", "forward": "z", "handedness": "right", "unit_metres": 1.0 });
    assert_eq!((&record["source_space"], &record["space"]), (&own, &own));
    let plain = folder.sinew("eval new.sinew demo.npz --json").json();
    let train = format!("{TRAIN} --predictor kernel {STATED} {UNREAL} --also lod1.obj --json");
    let record = folder.sinew(&train).json();
    let unreal = json!({ "up": "z", "forward": "x", "handedness": "left", "unit_metres": 0.01 });
    assert_eq!((&record["source_space"], &record["space"]), (&own, &unreal));
    assert_eq!(folder.sinew("inspect new.sinew --json").json()["space"], unreal);
    let text = folder.sinew("inspect new.sinew").done().out;
    assert!(text.contains("\nspace: up z, forward x, left-handed, unit 0.01 m\n"), "{text}");
    let found = folder.sinew(&format!("eval new.sinew demo.npz {STATED} --json")).json();
    for key in ["rms_percent", "p99_percent", "max_percent", "normal_rms_degrees"] {
        assert!((number(&found[key]) / number(&plain[key]) - 1.0).abs() < 1e-3, "{key}");
    }
    assert!((number(&found["diagonal"]) / number(&plain["diagonal"]) - 100.0).abs() < 1e-3);
    let line = folder.sinew("eval new.sinew demo.npz").failed();
    assert!(line.contains("--up, --forward and --unit"), "{line}");
    folder.sinew(&format!("report new.sinew demo.npz {STATED} --quick -o page.html")).done();
    // Back to glTF's space.
    let export = format!("export new.sinew --clip demo.npz {STATED} --also lod1.obj");
    let to = "--to-up y --to-forward z --to-unit 1";
    folder.sinew(&format!("{export} {to} -o out.glb")).done();
    let line = folder.sinew(&format!("{export} --to-hand left -o no.glb")).failed();
    assert!(line.starts_with("glTF is right-handed"), "{line}");
}

#[test]
fn spaces_that_cannot_be_are_refused_with_the_flag_that_helps() {
    let folder = Folder::with_demo("space-refused");
    let before = folder.list();
    for (flags, expected) in [
        ("--to-up z", "demo.npz: the file does not say which axis is up: say it with --up AXIS"),
        ("--up y --to-up z", "demo.npz: the file does not say which axis is forward: say it with"),
        ("--to-hand left", "demo.npz: the file does not say which axis is up: "),
        ("--to-unit 1", "demo.npz: the file does not say how long its unit is: say it with --unit"),
        ("--up y --forward -y", "demo.npz: up y and forward -y lie along one line: "),
        ("--up y --forward z --to-up z", "demo.npz: up z and forward z lie along one line: "),
    ] {
        let line = folder.sinew(&format!("{TRAIN} {flags}")).failed();
        assert!(line.starts_with(expected), "{line}");
        assert_eq!(folder.list(), before);
    }
    for flags in [
        "--unit 0",
        "--unit -1",
        "--unit nan",
        "--to-unit inf",
        "--up w",
        "--to-up up",
        "--to-hand both",
    ] {
        let run = folder.sinew(&format!("{TRAIN} {flags}"));
        let is_told = run.err.contains("expected ") || run.err.contains("possible values: ");
        assert!(run.code == Some(2) && is_told, "{flags}: {}", run.err);
    }
    let clip = "export demo.sinew --clip demo.npz -o out.glb";
    let line = folder.sinew(&format!("{clip} --up x")).failed();
    assert!(line.starts_with("the character stands along x: "), "{line}");
    let line = folder.sinew(&format!("{clip} --to-up z --to-forward x")).failed();
    assert!(line.contains("say it with --up AXIS"), "{line}");
    let at = |flags: &str| {
        folder.sinew(&format!("{clip} {flags}")).done();
        let glb = folder.read("out.glb");
        fs::remove_file(folder.path("out.glb")).unwrap();
        glb
    };
    assert!(at("") == at("--up y") && at("") != at("--up z"));
}
