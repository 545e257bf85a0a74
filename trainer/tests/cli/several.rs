//! Several files of one character, an animation of a skeleton only, and options for pipelines.

use super::TRAIN;
use super::common::{Folder, Set};
use serde_json::{Value, json};
use std::fs;

/// Writes some frames of the demo.
fn part(folder: &Folder, name: &str, frames: std::ops::Range<usize>) -> Set {
    let mut set = Set::demo();
    for array in ["vertices", "bone_transforms"] {
        let (shape, numbers) = set.reals.get_mut(array).unwrap();
        let each = numbers.len() / shape[0] as usize;
        *numbers = numbers[each * frames.start..each * frames.end].to_vec();
        shape[0] = frames.len() as u64;
    }
    let (shape, split) = set.wholes.get_mut("split").unwrap();
    *split = split[frames.clone()].to_vec();
    shape[0] = frames.len() as u64;
    set.write(&folder.path(name));
    set
}

#[test]
fn frames_of_several_files_follow_one_another() {
    let folder = Folder::with_demo("several");
    part(&folder, "walk.npz", 0..20);
    part(&folder, "jump.npz", 20..52);
    let mut all = part(&folder, "all.npz", 0..52);
    all.json["clip_names"] = json!(["walk", "jump"]);
    all.json["clip_starts"] = json!([0, 20]);
    all.write(&folder.path("all.npz"));
    folder.sinew(&TRAIN.replace("demo.npz", "all.npz")).done();
    let whole = folder.read("new.sinew");
    let train = TRAIN.replace("demo.npz", "walk.npz jump.npz").replace("new.sinew", "joined.sinew");
    let record = folder.sinew(&format!("{train} --json")).json();
    assert_eq!(record["inputs"].as_array().unwrap().len(), 4, "arrays and names of both");
    assert!(folder.read("joined.sinew") == whole, "the same frames give the same bytes");
    let found = folder.sinew("eval new.sinew walk.npz jump.npz --split all --json").json();
    assert_eq!((&found["frames"], &found["read"]), (&json!(52), &json!(40)));
    let train = format!("{train} --hold-out-clip jump --json");
    let held_out = folder.sinew(&train).json()["held_out_frames"].as_array().unwrap().len();
    assert_eq!(held_out, 32);

    let mut other = part(&folder, "other.npz", 20..52);
    other.reals.get_mut("rest").unwrap().1[0] += 1.0;
    other.write(&folder.path("other.npz"));
    let mut shuffled = part(&folder, "shuffled.npz", 20..52);
    for array in ["rest", "vertices"] {
        let all = &mut shuffled.reals.get_mut(array).unwrap().1;
        let each = 3 * shuffled_len();
        for frame in all.chunks_mut(each) {
            let (first, last) = frame.split_at_mut(3);
            first.swap_with_slice(&mut last[each - 6..]);
        }
    }
    shuffled.write(&folder.path("shuffled.npz"));
    let mut renamed = part(&folder, "renamed.npz", 20..52);
    renamed.json["bone_names"][6] = json!("paw");
    renamed.write(&folder.path("renamed.npz"));
    for (file, expected) in [
        ("other.npz", "its rest mesh is not that of walk.npz: off by "),
        ("shuffled.npz", "its rest mesh is not that of walk.npz: off by "),
        ("renamed.npz", "joint 6 is paw under "),
    ] {
        let line = folder.sinew(&format!("train walk.npz {file} -o none.sinew")).failed();
        assert!(line.starts_with(&format!("{file}: {expected}")), "{line}");
        let is_shuffled = line.contains("the same vertices in another order");
        assert_eq!(is_shuffled, file == "shuffled.npz", "{line}");
    }
    let line =
        folder.sinew("train walk.npz jump.npz --importance a --importance b --importance c -o n");
    let expected = "--importance: expected one for all files or one for each of 2, found 3";
    assert_eq!(line.failed(), expected);
    assert!(!folder.path("none.sinew").exists());
}

fn shuffled_len() -> usize {
    Set::demo().vertex_len()
}

#[test]
fn a_pipeline_fails_above_an_error_and_nothing_is_written() {
    let folder = Folder::with_demo("fail-above");
    let line = folder.sinew(&format!("{TRAIN} --fail-above 0.001")).failed();
    assert!(line.ends_with(", above --fail-above 0.001: nothing was written"), "{line}");
    assert!(!folder.path("new.sinew").exists());
    folder.sinew(&format!("{TRAIN} --fail-above 99 --threads 1")).done();
    let one = folder.read("new.sinew");
    folder.sinew(&format!("{TRAIN} --threads 2")).done();
    assert!(folder.read("new.sinew") == one, "the same bytes for any number of threads");
    let run = folder.sinew("eval new.sinew demo.npz --fail-above 0.001");
    assert!(run.code == Some(1) && run.out.contains("LBS") && run.err.contains("--fail-above"));
    let found = folder.sinew("eval new.sinew demo.npz --json").json();
    let joints: Vec<&Value> = found["regions"].as_array().unwrap().iter().collect();
    assert!(joints.len() > 1 && joints.iter().all(|region| region["kind"] == "joint"));
    let vertices: u64 = joints.iter().map(|region| region["vertices"].as_u64().unwrap()).sum();
    assert_eq!(vertices as usize, Set::demo().vertex_len());
}

#[test]
fn a_clip_without_motion_is_refused() {
    let folder = Folder::with_demo("no-motion");
    let mut set = Set::demo();
    for array in ["vertices", "bone_transforms"] {
        let (shape, numbers) = set.reals.get_mut(array).unwrap();
        let first = numbers[..numbers.len() / shape[0] as usize].to_vec();
        *numbers = first.repeat(shape[0] as usize);
    }
    set.write(&folder.path("still.npz"));
    let line = folder.sinew("train still.npz -o none.sinew").failed();
    assert_eq!(line, "still.npz: all 40 training frames are one pose: there is no motion to learn");
}

/// Removes the meshes and skins from a GLB.
fn joints_alone(glb: &[u8]) -> Vec<u8> {
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let (json_len, rest) = (length(12), &glb[20 + length(12)..]);
    let mut json: Value = serde_json::from_slice(&glb[20..20 + json_len]).unwrap();
    for key in ["meshes", "skins", "materials"] {
        json.as_object_mut().unwrap().remove(key);
    }
    for node in json["nodes"].as_array_mut().unwrap() {
        for key in ["mesh", "skin"] {
            node.as_object_mut().unwrap().remove(key);
        }
    }
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let all = 20 + text.len() + rest.len();
    let mut out = [&glb[..8], &(all as u32).to_le_bytes()].concat();
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend(rest);
    out
}

#[test]
fn an_animation_of_joints_alone_plays_on_the_mesh_of_another_file() {
    let folder = Folder::new("joints-alone-clip");
    folder.sinew("export-demo . --vertices 300 --poses 20 --held-out 5").done();
    let train = "train demo.glb --targets demo.pc2 --predictor kernel --proxies 4 -o m.sinew";
    folder.sinew(train).done();
    fs::write(folder.path("bare.glb"), joints_alone(&folder.read("demo.glb"))).unwrap();
    folder.sinew("export m.sinew --clip demo.glb -o whole.glb").done();
    let line = folder.sinew("export m.sinew --clip bare.glb -o none.glb").failed();
    let expected = "bare.glb: holds joints and no mesh: give a file that has the character's mesh as \
                    well, with --mesh or --into";
    assert_eq!(line, expected);
    folder.sinew("export m.sinew --clip bare.glb --mesh demo.glb -o played.glb").done();
    let [whole, played] = ["whole.glb", "played.glb"].map(|name| numbers(&folder.read(name)));
    assert!(whole.len() > 1000 && whole.len() == played.len());
    let apart = whole.iter().zip(&played).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(apart < 1e-4, "{apart}");
    folder.sinew("export m.sinew --clip bare.glb --into demo.glb -o into.glb --quiet").done();
    let line = folder.sinew("export m.sinew --clip demo.pc2 --mesh demo.glb -o none.glb").failed();
    assert!(line.contains("expected a file that ends in .glb, .gltf or .fbx"), "{line}");
}

/// Lists the output values of all animations in a GLB.
fn numbers(glb: &[u8]) -> Vec<f32> {
    let gltf = gltf::Gltf::from_slice(glb).unwrap();
    let blob = gltf.blob.as_deref().unwrap();
    let mut all = Vec::new();
    for channel in gltf.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>())
    {
        let reader = channel.reader(|_| Some(blob));
        match reader.read_outputs().unwrap() {
            gltf::animation::util::ReadOutputs::Translations(own) => all.extend(own.flatten()),
            gltf::animation::util::ReadOutputs::Rotations(own) => {
                all.extend(own.into_f32().flatten())
            }
            gltf::animation::util::ReadOutputs::Scales(own) => all.extend(own.flatten()),
            gltf::animation::util::ReadOutputs::MorphTargetWeights(own) => {
                all.extend(own.into_f32())
            }
        }
    }
    all
}
