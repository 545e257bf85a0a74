//! `sinew export` and `sinew export-demo`: files, messages and refusals.

use super::common::{Folder, HELD_OUT, Set, TRAINING};
use serde_json::json;
use std::fs;

/// Writes the demo's rest mesh, scaled, as an OBJ of triangles.
pub(crate) fn write_obj(folder: &Folder, name: &str, scale: f64) {
    let set = Set::demo();
    let mut text = "o arm\n".to_owned();
    for x in set.reals["rest"].1.chunks(3) {
        text += &format!("v {} {} {}\n", scale * x[0], scale * x[1], scale * x[2]);
    }
    for face in set.wholes["tris"].1.chunks(3) {
        text += &format!("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
    }
    fs::write(folder.path(name), text).unwrap();
}

const EXPORT: &str = "export demo.sinew --clip demo.npz";

#[test]
fn an_export_holds_the_mesh_the_levels_and_an_animation_a_clip() {
    let folder = Folder::with_demo("export");
    write_obj(&folder, "lod1.obj", 1.0);
    let found = folder.sinew(&format!("{EXPORT} --also lod1.obj -o out.glb --json")).json();
    let glb = folder.read("out.glb");
    assert_eq!(found["bytes"], glb.len());
    let frames = TRAINING + HELD_OUT;
    assert_eq!(found["animations"], json!([{ "name": "demo", "frames": frames }]));
    let level = &found["levels"][0];
    assert_eq!(
        (&level["name"], &level["vertices"]),
        (&json!("lod1"), &json!(Set::demo().vertex_len()))
    );
    let gltf = gltf::Gltf::from_slice(&glb).unwrap();
    let meshes: Vec<_> = gltf.meshes().map(|mesh| mesh.name().unwrap()).collect();
    assert_eq!(meshes, ["skin", "lod1"]);
    assert!(gltf.nodes().filter(|node| node.mesh().is_some()).all(|node| node.skin().is_some()));
    assert_eq!(gltf.animations().next().unwrap().name(), Some("demo"));
    let generator = gltf.document.into_json().asset.generator.unwrap();
    assert_eq!(generator, format!("sinew {}", env!("CARGO_PKG_VERSION")));
    let text = folder.sinew(&format!("{EXPORT} --also lod1.obj -o again.glb")).done().out;
    assert!(text.contains("transferred") && text.contains("demo (52 frames)"), "{text}");
    assert!(folder.read("again.glb") == glb, "the same input gives the same bytes");
}

/// `tests/tools` plays such files.
#[test]
fn an_output_that_ends_in_usda_is_usd() {
    let folder = Folder::with_demo("export-usd");
    let found = folder.sinew(&format!("{EXPORT} -o out.usda --json")).json();
    let text = String::from_utf8(folder.read("out.usda")).unwrap();
    assert_eq!(found["bytes"], text.len());
    let frames = TRAINING + HELD_OUT;
    assert_eq!(found["animations"], json!([{ "name": "demo", "frames": frames }]));
    assert!(text.starts_with("#usda 1.0\n(\n    defaultPrim = \"armature\"\n"), "{}", &text[..99]);
    assert!(text.contains("def SkelAnimation \"demo\""));
}

#[test]
fn every_clip_of_a_scene_becomes_an_animation_with_its_name_and_times() {
    let folder = Folder::with_demo("export-clips");
    let size = format!("--vertices 300 --poses {TRAINING} --held-out {HELD_OUT}");
    folder.sinew(&format!("export-demo rig {size}")).done();
    folder.sinew("export demo.sinew --clip rig/demo.glb -o out.glb --quiet").done();
    let found = animations(&folder, "out.glb");
    let clips = animations(&folder, "rig/demo.glb");
    assert_eq!(clips.iter().map(|clip| &clip.0[..]).collect::<Vec<_>>(), ["train", "held-out"]);
    assert_eq!([clips[0].1.len(), clips[1].1.len()], [TRAINING, HELD_OUT]);
    for ((name, times), (clip, own)) in found.iter().zip(&clips) {
        assert_eq!((name, times.first(), times.last()), (clip, own.first(), own.last()));
        // Unrelated poses need keys between them.
        assert!(
            times.len() > own.len() && own.iter().all(|time| times.contains(time)),
            "{times:?}"
        );
    }
    folder.sinew("export demo.sinew --clip rig/demo.glb --fps 30 -o out.glb --quiet").done();
    assert_eq!(animations(&folder, "out.glb"), clips);
}

/// Reads the names of a GLB's animations and their key times.
fn animations(folder: &Folder, name: &str) -> Vec<(String, Vec<f32>)> {
    let glb = gltf::Gltf::from_slice(&folder.read(name)).unwrap();
    let blob = glb.blob.clone().unwrap();
    let times = |animation: gltf::Animation<'_>| -> Vec<f32> {
        let channel = animation.channels().next().unwrap();
        channel.reader(|_| Some(blob.as_slice())).read_inputs().unwrap().collect()
    };
    let name = |animation: &gltf::Animation<'_>| animation.name().unwrap().to_owned();
    glb.animations().map(|animation| (name(&animation), times(animation))).collect()
}

/// As `blender_export.py` writes files: z up, and named clips at 24 frames a second.
#[test]
fn clips_and_space_of_an_npz_reach_the_export() {
    const WAVE: usize = 20;
    let folder = Folder::with_demo("clips-and-space");
    let mut set = Set::demo();
    for (key, value) in [
        ("clip_names", json!(["walk", "wave"])),
        ("clip_starts", json!([0, WAVE])),
        ("fps", json!(24)),
        ("up", json!("z")),
        ("forward", json!("-y")),
        ("unit", json!(0.01)),
    ] {
        set.json[key] = value;
    }
    set.write(&folder.path("clips.npz"));
    let trains = |frames: &[i64]| frames.iter().filter(|&&split| split == 0).count();
    let split = &set.wholes["split"].1;
    let fit = "--predictor kernel --proxies 4 -o new.sinew --json";
    let record = folder.sinew(&format!("train clips.npz --clip wave {fit}")).json();
    let found = record["training_frames"].as_array().unwrap().len();
    assert_eq!(found, trains(&split[WAVE..]));
    let record = folder.sinew(&format!("train clips.npz --hold-out-clip wave {fit}")).json();
    let found = record["training_frames"].as_array().unwrap().len();
    assert_eq!(found, trains(&split[..WAVE]));

    // Errors of measuring and playing use the frame numbers and joint names of the file.
    let mut bad = Set::demo();
    bad.json = set.json.clone();
    let numbers = (0..TRAINING + HELD_OUT).map(|frame| 101 + frame as i64);
    bad.wholes.insert("frame_numbers", (vec![(TRAINING + HELD_OUT) as u64], numbers.collect()));
    let frame = bad.frames(1)[2];
    let place = 16 * (frame * bad.joint_len() + 6);
    let maps = &mut bad.reals.get_mut("bone_transforms").unwrap().1;
    maps[place..place + 3].iter_mut().for_each(|x| *x = -*x);
    bad.write(&folder.path("bad.npz"));
    for command in ["eval new.sinew bad.npz", "export new.sinew --clip bad.npz -o none.glb"] {
        let expected = format!("bad.npz: frame {}: joint hand is mirrored", 101 + frame);
        let line = folder.sinew(&format!("{command} --quiet")).failed();
        assert!(line.starts_with(&expected), "{line}");
    }

    folder.sinew("export new.sinew --clip clips.npz -o out.glb").done();
    let times = |len: usize| (0..len).map(|key| (key as f64 / 24.0) as f32).collect::<Vec<_>>();
    let rest = TRAINING + HELD_OUT - WAVE;
    let expected = [("walk".to_owned(), times(WAVE)), ("wave".to_owned(), times(rest))];
    assert_eq!(animations(&folder, "out.glb"), expected);
    // Y up and in metres by default.
    folder
        .sinew("export new.sinew --clip clips.npz --to-up y --to-forward z --to-unit 1 -o to.glb")
        .done();
    let glb = folder.read("out.glb");
    assert!(glb == folder.read("to.glb"));
    let glb = gltf::Gltf::from_slice(&glb).unwrap();
    let armature = glb.nodes().find(|node| node.name() == Some("armature")).unwrap();
    let (_, [x, y, z, w], scale) = armature.transform().decomposed();
    let half = 0.5_f32.sqrt();
    assert!((x + half).abs() < 1e-6 && y.abs() + z.abs() < 1e-6 && (w - half).abs() < 1e-6);
    assert!(scale.iter().all(|scale| (scale - 0.01).abs() < 1e-8), "{scale:?}");
}

#[test]
fn impossible_exports_are_refused_and_write_nothing() {
    let folder = Folder::with_demo("export-refused");
    write_obj(&folder, "far.obj", 1e6);
    fs::write(folder.path("empty.obj"), "o nothing\n").unwrap();
    fs::write(folder.path("text.obj"), "v one two three\n").unwrap();
    fs::create_dir(folder.path("inner")).unwrap();
    let mut other = Set::demo();
    other.json["bone_names"][6] = json!("paw");
    other.write(&folder.path("other.npz"));
    let before = folder.list();
    for (command, expected) in [
        (
            "export demo.sinew --clip other.npz -o out.glb".to_owned(),
            "other.npz: joint 6 is called hand in the model, paw in the examples",
        ),
        (
            "export demo.npz --clip demo.npz -o out.glb".to_owned(),
            "demo.npz: holds what a .npz file holds, expected a model, which commands take first",
        ),
        (
            "export demo.sinew --clip inner -o out.glb".to_owned(),
            "inner: is a folder, expected a file",
        ),
        (format!("{EXPORT} -o demo.npz"), "cannot write demo.npz: it is an input"),
        (format!("{EXPORT} -o demo.json"), "cannot write demo.json: it is an input"),
        (format!("{EXPORT} -o demo.sinew"), "cannot write demo.sinew: it is an input"),
        (format!("{EXPORT} --also far.obj -o far.obj"), "cannot write far.obj: it is an input"),
        (format!("{EXPORT} -o inner"), "cannot write inner: it is a folder"),
        (format!("{EXPORT} -o no/out.glb"), "cannot write no/out.glb: there is no folder no"),
        (format!("{EXPORT} --also none.obj -o out.glb"), "none.obj: cannot be read: "),
        (
            format!("{EXPORT} --also inner -o out.glb"),
            "inner: is a folder, expected a mesh (.obj, .glb, .gltf, .fbx)",
        ),
        (format!("{EXPORT} --also empty.obj -o out.glb"), "empty.obj: "),
        (format!("{EXPORT} --also text.obj -o out.glb"), "text.obj: "),
        (format!("{EXPORT} --also far.obj -o out.glb"), "mesh far is "),
    ] {
        let line = folder.sinew(&command).failed();
        assert!(line.starts_with(expected), "{command}: {line}");
        assert_eq!(folder.list(), before, "{command}");
    }
}

#[test]
fn a_model_goes_into_the_artist_s_own_file() {
    let folder = Folder::with_demo("export-into");
    let size = format!("--vertices 300 --poses {TRAINING} --held-out {HELD_OUT}");
    folder.sinew(&format!("export-demo rig {size}")).done();
    let before = folder.read("rig/demo.glb");
    let run = folder.sinew(&format!("{EXPORT} --into rig/demo.glb -o out.glb"));
    assert_eq!(run.code, Some(0), "{}", run.err);
    let expected = "sinew: warning: rig/demo.glb: animations that it had move the joints and no \
                    helper: train, held-out\n";
    assert_eq!(run.err, expected);
    assert!(run.out.contains("\nmeshes: skin\nanimations: demo (52 frames)\n"), "{}", run.out);
    let gltf = gltf::Gltf::from_slice(&folder.read("out.glb")).unwrap();
    let names: Vec<_> = gltf.animations().map(|animation| animation.name().unwrap()).collect();
    assert_eq!(names, ["train", "held-out", "demo"]);
    let run = folder.sinew(&format!("{EXPORT} --into rig/demo.glb -o again.glb --json --quiet"));
    let found: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let into = json!({
        "meshes": ["skin"], "added_joints": [], "kept_animations": ["train", "held-out"],
    });
    assert_eq!(found["into"], into);
    assert!(folder.read("again.glb") == folder.read("out.glb"), "the same bytes again");

    fs::write(folder.path("text.glb"), "no glTF").unwrap();
    let list = folder.list();
    for (options, expected) in [
        ("--into rig/demo.glb -o rig/demo.glb", "cannot write rig/demo.glb: it is an input"),
        ("--into none.glb -o new.glb", "none.glb: cannot be read: "),
        ("--into text.glb -o new.glb", "text.glb: is no glTF 2.0: "),
        (
            "--into rig/demo.glb -o new.usda",
            "--into rig/demo.glb gives a GLB: name the output .glb",
        ),
    ] {
        let line = folder.sinew(&format!("{EXPORT} {options}")).failed();
        assert!(line.starts_with(expected), "{options}: {line}");
        assert_eq!(folder.list(), list, "{options}");
    }
    for option in ["--to-up y", "--to-unit 1"] {
        let run = folder.sinew(&format!("{EXPORT} --into rig/demo.glb -o new.glb {option}"));
        assert_eq!(run.code, Some(2), "{option}: {}", run.err);
    }
    assert!(folder.read("rig/demo.glb") == before);
}

#[test]
fn strays_of_a_level_are_warned_of() {
    let folder = Folder::with_demo("export-stray");
    write_obj(&folder, "lod1.obj", 1.0);
    let text = String::from_utf8(folder.read("lod1.obj")).unwrap();
    fs::write(folder.path("lod1.obj"), text.replacen("\nv ", "\nv 9 9 9 ", 1)).unwrap();
    let run = folder.sinew(&format!("{EXPORT} --also lod1.obj -o out.glb"));
    assert_eq!(run.code, Some(0));
    let expected = "sinew: warning: lod1.obj: vertices further than 10 % of the diagonal from the \
                    model's surface, which follow their nearest point: 1\n";
    assert_eq!(run.err, expected);
}

#[test]
fn the_demo_s_rig_and_point_cache_are_written_with_the_next_command() {
    let folder = Folder::new("export-demo");
    let size = "--vertices 200 --poses 8 --held-out 3";
    let text = folder.sinew(&format!("export-demo rig {size}")).done().out;
    let (_, next) = text.trim_end().split_once("next: sinew ").unwrap();
    assert_eq!(
        next,
        "train rig/demo.glb --targets rig/demo.pc2 --hold-out-clip held-out -o demo.sinew"
    );
    let text = folder.sinew(next).done().out;
    assert!(text.contains("8 training, 3 held-out, 0 extreme frames"), "{text}");
    let glb = folder.read("rig/demo.glb");
    let gltf = gltf::Gltf::from_slice(&glb).unwrap();
    let names: Vec<_> = gltf.animations().map(|animation| animation.name().unwrap()).collect();
    assert_eq!(names, ["train", "held-out"]);
    let mesh = gltf.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let points = primitive.get(&gltf::Semantic::Positions).unwrap().count();
    assert_eq!(folder.read("rig/demo.pc2").len(), 32 + 12 * points * 11);
    fs::write(folder.path("file"), "").unwrap();
    let line = folder.sinew(&format!("export-demo file {size}")).failed();
    assert!(line.starts_with("cannot make the folder file: "), "{line}");
    folder.sinew(&format!("export-demo other {size}")).done();
    assert!(folder.read("other/demo.glb") == glb, "the same options give the same bytes");
}
