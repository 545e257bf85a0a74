//! Warnings: each appears once, with the user's names.

use super::glb::Glb;
use super::with_cases;
use crate::cli::common::{Folder, Run, Set};
use models::shared;
use serde_json::json;

/// Returns the lines of both streams that contain all the words.
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
fn a_kernel_is_not_warned_of_half_turns() {
    let Some(fox) = shared("gltf-loader/Fox.glb") else { return };
    let folder = Folder::new("half-turn-kernel");
    std::fs::copy(fox, folder.path("fox.glb")).unwrap();
    let run = folder.sinew("train fox.glb -o m.sinew --predictor kernel --proxies 4");
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(!run.err.contains("half turn"), "{run:?}");
}

#[test]
fn a_joint_near_a_half_turn_is_named_once() {
    let Some(fox) = shared("gltf-loader/Fox.glb") else { return };
    let folder = Folder::new("half-turn");
    std::fs::copy(fox, folder.path("fox.glb")).unwrap();
    let run = folder.sinew("train fox.glb -o m.sinew --predictor rotational --proxies 4");
    assert_eq!(lines(&run, &["b_LeftHand_011", "166°"]).len(), 1, "{run:?}");
}

/// Returns a GLB in which the second element of the first primitive's accessor `name` has another
/// number.
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

#[test]
fn a_joint_weight_that_is_not_finite_is_named_and_not_called_absent() {
    let Some(folder) = with_cases("weight-words", &["gltf/plain.glb"]) else { return };
    let glb = folder.read("plain.glb");
    for (number, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        // The four weights of vertex 0 are contiguous; the fourth number is its last weight.
        std::fs::write(folder.path("bad.glb"), spoiled(&glb, "WEIGHTS_0", number)).unwrap();
        let expected = format!(
            "bad.glb: mesh tube: vertex 0 has the joint weight {word}, expected a finite number: normalize the weights \
             and export again"
        );
        assert_eq!(folder.sinew("check bad.glb").failed(), expected);
    }
}

#[test]
fn a_pose_that_is_not_finite_is_named_by_the_file_that_has_it() {
    let cases = ["gltf/plain.glb", "gltf/plain_targets.npz"];
    let Some(folder) = with_cases("pose-words", &cases) else { return };
    let mut glb = Glb::read(&folder, "plain.glb");
    let sampler = &glb.json["animations"][0]["samplers"][0];
    let mut keys: Vec<f32> = glb.values(&sampler["output"]).into_iter().map(|x| x as f32).collect();
    keys[..4].fill(f32::NAN);
    let output = glb.floats("VEC4", 4, &keys);
    glb.json["animations"][0]["samplers"][0]["output"] = json!(output);
    glb.write(&folder, "bad.glb");
    let line = folder.sinew("train bad.glb --targets plain_targets.npz -o m.sinew").failed();
    assert!(
        line.starts_with("bad.glb: frame 0: the animated pose is not finite at joint "),
        "{line}"
    );
    // The file contains an animation, so it is read as a sequence of meshes.
    let line = folder.sinew("train plain.glb --targets bad.glb -o m.sinew").failed();
    assert!(
        line.starts_with("bad.glb: its vertices are not finite in frame 0, at vertex "),
        "{line}"
    );
}

#[test]
fn a_scene_that_is_cut_short_says_how_long_it_should_be_to_every_command() {
    let Some(folder) = with_cases("cut-words", &["gltf/plain.glb"]) else { return };
    super::run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    let glb = folder.read("plain.glb");
    for len in (0..=13).chain([glb.len() - 1]) {
        std::fs::write(folder.path("cut.glb"), &glb[..len]).unwrap();
        let whole = if len < 12 { 12 } else { glb.len() };
        let expected = match len {
            0 => "cut.glb: is empty".to_owned(),
            _ => format!(
                "cut.glb: is cut short: expected at least {whole} bytes, found {len}; export it, or copy it, again"
            ),
        };
        for command in [
            "check cut.glb",
            "train plain.glb --targets cut.glb -o n.sinew",
            "train plain.glb --also cut.glb -o n.sinew",
            "export m.sinew --clip cut.glb -o o.glb",
            "export m.sinew --clip plain.glb --mesh cut.glb -o o.glb",
            "export m.sinew --clip plain.glb --into cut.glb -o o.glb",
            "face train --basis cut.glb -o f.sinew",
        ] {
            let line = super::refused(&folder, command);
            assert_eq!(line, format!("sinew: {expected}"), "{command}");
        }
    }
    std::fs::write(folder.path("cut.glb"), "no scene").unwrap();
    let line = folder.sinew("check cut.glb").failed();
    let expected =
        "cut.glb: is no glTF 2.0: it begins neither with glTF nor, as JSON, with a brace";
    assert_eq!(line, expected);
}

#[test]
fn common_findings_of_several_files_are_reported_once() {
    let Some(folder) = with_cases("twice", &["gltf/plain.glb"]) else { return };
    std::fs::copy(folder.path("plain.glb"), folder.path("second.glb")).unwrap();
    for (files, names) in
        [("plain.glb second.glb", "plain.glb, second.glb"), ("plain.glb plain.glb", "plain.glb")]
    {
        let run = folder.sinew(&format!("train {files} --predictor kernel -o m.sinew"));
        let found = lines(&run, &["no shapes move and no targets are given"]);
        assert_eq!(found.len(), 1, "{run:?}");
        assert!(found[0].starts_with(&format!("sinew: warning: {names}: no shapes")), "{run:?}");
    }
}

#[test]
fn a_share_that_runs_are_too_short_for_is_not_called_held_out() {
    let folder = Folder::with_demo("rounded");
    // 52 frames in runs of 10 or 11: each run keeps one frame for training.
    let train = "train demo.npz -o m.sinew --predictor kernel --proxies 2 --hold-out";
    let run = folder.sinew(&format!("{train} 0.5"));
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    let run = folder.sinew(&format!("{train} 0.001"));
    let expected = "sinew: warning: demo.npz: 5 of 52 frames are held out, 10 % and not 0.1 %: ";
    assert!(run.code == Some(0) && run.err.starts_with(expected), "{run:?}");
}
