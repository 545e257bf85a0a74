//! Warnings: each is printed once, and names the user's own things.

use super::with_cases;
use crate::common::{Folder, Run, Set};
use crate::shared::shared;

/// Lines of both streams that hold all these words.
fn lines<'a>(run: &'a Run, words: &[&str]) -> Vec<&'a str> {
    let all = run.err.lines().chain(run.out.lines());
    all.filter(|line| words.iter().all(|word| line.contains(word))).collect()
}

#[test]
fn a_joint_that_is_not_rigid_is_named_once() {
    let Some(folder) = with_cases("scalenoise", &["gltf/scalenoise.glb"]) else { return };
    let train = "train scalenoise.glb -o m.sinew --record record.json";
    for command in [train, "check scalenoise.glb", "eval m.sinew scalenoise.glb"] {
        let run = folder.sinew(command);
        assert_eq!(run.code, Some(0), "{run:?}");
        for joint in ["root", "mid", "tip"] {
            let name = format!("joint {joint} ");
            assert_eq!(lines(&run, &[&name, "not rigid"]).len(), 1, "{command}: {run:?}");
        }
        assert!(lines(&run, &["array"]).is_empty(), "{command}: {run:?}");
    }
    let record = folder.json("record.json");
    let mut warnings: Vec<_> = record["warnings"].as_array().unwrap().iter().collect();
    let len = warnings.len();
    warnings.dedup();
    assert_eq!((len, warnings.len()), (4, 4), "the plain skin and three joints: {warnings:?}");
}

#[test]
fn the_number_of_warnings_is_that_of_those_printed() {
    let Some(folder) = with_cases("scalenoise-count", &["gltf/scalenoise.glb"]) else { return };
    let run = folder.sinew("check scalenoise.glb");
    let printed = lines(&run, &["warning: "]).len();
    assert!(run.out.contains(&format!("\n{printed} warnings, ")), "{run:?}");
}

#[test]
fn a_triangle_without_area_is_named_once() {
    let folder = Folder::with_demo("flat-once");
    let mut set = Set::demo();
    let corners = &mut set.wholes.get_mut("tris").unwrap().1;
    corners[3 * 60 + 1] = corners[3 * 60];
    set.write(&folder.path("flat.npz"));
    let run = folder.sinew("check flat.npz");
    assert_eq!(lines(&run, &["triangles that name a vertex twice", " 60"]).len(), 1, "{run:?}");
    // A training does not print the notes of a check.
    let run = folder.sinew("train flat.npz -o m.sinew --predictor kernel --proxies 2");
    assert_eq!(lines(&run, &["triangles that name a vertex twice", " 60"]).len(), 1, "{run:?}");
}

#[test]
fn a_joint_near_a_half_turn_is_named_once() {
    let Some(fox) = shared("gltf-loader/Fox.glb") else { return };
    let folder = Folder::new("half-turn");
    std::fs::copy(fox, folder.path("fox.glb")).unwrap();
    let run = folder.sinew("train fox.glb -o m.sinew --predictor rotational --proxies 4");
    assert_eq!(lines(&run, &["b_LeftHand_011", "166°"]).len(), 1, "{run:?}");
}

/// Writes a GLB whose accessor `name` of the first primitive has another number at its second element.
fn spoiled(glb: &[u8], name: &str, number: f32) -> Vec<u8> {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let accessor = &json["meshes"][0]["primitives"][0]["attributes"][name];
    let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let offset = |of: &serde_json::Value| of["byteOffset"].as_u64().unwrap_or(0) as usize;
    let mut out = glb.to_vec();
    let at = 28 + length + offset(view) + offset(accessor) + 12;
    out[at..at + 4].copy_from_slice(&number.to_le_bytes());
    out
}

#[test]
fn a_number_that_is_wrong_is_named_by_its_place_in_the_scene() {
    let Some(folder) = with_cases("scene-words", &["gltf/plain.glb"]) else { return };
    let glb = folder.read("plain.glb");
    for (number, expected) in [
        (f32::NAN, "the rest mesh is not finite at vertex 1"),
        (1e30, "the rest mesh exceeds 1e9, the most a model can hold, at vertex 1"),
    ] {
        std::fs::write(folder.path("bad.glb"), spoiled(&glb, "POSITION", number)).unwrap();
        assert_eq!(folder.sinew("check bad.glb").failed(), format!("bad.glb: {expected}"));
    }
}
