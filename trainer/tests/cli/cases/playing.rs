//! Cases of the folder `gltf`: playing.

use super::glb::Glb;
use super::{apart, off, off_as_exported, refused, run, with_cases};
use serde_json::json;

#[test]
fn steps_and_curves_play_as_the_clip_does() {
    let cases = ["gltf/step.glb", "gltf/cubic.glb", "gltf/plain.glb"];
    let Some(folder) = with_cases("steps", &cases) else { return };
    for (file, bound) in [("step.glb", 1e-3), ("cubic.glb", 0.1)] {
        let off = off_as_exported(&folder, file);
        println!("{file}: off by {off:?} %");
        assert!(off.iter().all(|&off| off <= bound), "{file}: {off:?}");
    }
    // A clip that mixes all three interpolations and starts late; one joint has another last key.
    let mut glb = Glb::read(&folder, "cubic.glb");
    let plain = Glb::read(&folder, "plain.glb");
    let turns: Vec<f32> = plain
        .values(&plain.json["animations"][0]["samplers"][1]["output"])
        .into_iter()
        .map(|x| x as f32)
        .collect();
    let late = |times: &[f64]| times.iter().map(|time| (time + 0.7) as f32).collect::<Vec<_>>();
    let times = late(&glb.times(0, 0));
    let all = glb.floats("SCALAR", 1, &times);
    let few = glb.floats("SCALAR", 1, &times[..7]);
    let few_turns = glb.floats("VEC4", 4, &turns[..4 * 7]);
    let turns = glb.floats("VEC4", 4, &turns);
    let samplers = &mut glb.json["animations"][0]["samplers"];
    samplers[0]["input"] = json!(all);
    samplers[1] = json!({ "input": few, "output": few_turns, "interpolation": "STEP" });
    samplers[2] = json!({ "input": all, "output": turns, "interpolation": "LINEAR" });
    glb.write(&folder, "mixed.glb");
    let off = off_as_exported(&folder, "mixed.glb");
    println!("mixed.glb: off by {off:?} %");
    assert!(off.iter().all(|&off| off <= 0.1), "{off:?}");
}

#[test]
fn a_joint_that_steps_keeps_its_steps_and_jumps_have_two_keys() {
    let Some(folder) = with_cases("keys", &["gltf/step.glb"]) else { return };
    run(&folder, "-q train --predictor kernel step.glb -o m.sinew");
    let source = Glb::read(&folder, "step.glb");
    for into in ["", "--into step.glb"] {
        run(&folder, &format!("-q export m.sinew --clip step.glb {into} -o out.glb"));
        let played = Glb::read(&folder, "out.glb");
        let clip = played.json["animations"].as_array().unwrap().len() - 1;
        for joint in ["root", "mid", "tip"] {
            let turned = ("rotation".to_owned(), "STEP".to_owned());
            assert!(played.interpolations(clip, joint).contains(&turned), "{joint}");
        }
        assert_eq!(played.times(clip, 0), source.times(0, 0));
    }
    // A joint that moves between keys stays linear, with pairs of keys.
    let mut mixed = Glb::read(&folder, "step.glb");
    mixed.json["animations"][0]["samplers"][0]["interpolation"] = json!("LINEAR");
    mixed.write(&folder, "mixed.glb");
    run(&folder, "-q export m.sinew --clip mixed.glb -o out.glb");
    let played = Glb::read(&folder, "out.glb");
    let how = |joint: &str| {
        let all = played.interpolations(0, joint);
        all.into_iter().find(|(path, _)| path == "rotation").unwrap().1
    };
    assert_eq!(["root", "mid", "tip"].map(how), ["LINEAR", "STEP", "STEP"]);
}

#[test]
fn clips_keep_their_times_and_stay_in_step() {
    let cases = ["gltf/latestart.glb", "gltf/plain.glb"];
    let Some(folder) = with_cases("latestart", &cases) else { return };
    run(&folder, "-q train --predictor kernel latestart.glb -o m.sinew");
    let ends = |glb: &Glb, clip: usize| {
        let times = glb.times(clip, 0);
        [times[0], times[times.len() - 1]]
    };
    // A second clip that starts at another time.
    let mut two = Glb::read(&folder, "latestart.glb");
    let times: Vec<f32> = two.times(0, 0).iter().map(|time| (0.5 * time + 4.0) as f32).collect();
    let times = two.floats("SCALAR", 1, &times);
    let mut second = two.json["animations"][0].clone();
    second["name"] = json!("second");
    second["samplers"].as_array_mut().unwrap().iter_mut().for_each(|s| s["input"] = json!(times));
    two.json["animations"].as_array_mut().unwrap().push(second);
    two.write(&folder, "two.glb");
    for (file, more, expected) in [
        ("latestart.glb", "", vec![[1.5, 3.5]]),
        ("latestart.glb", "--mesh plain.glb", vec![[1.5, 3.5]]),
        ("two.glb", "", vec![[1.5, 3.5], [4.75, 5.75]]),
        ("two.glb", "--into two.glb", vec![[1.5, 3.5], [4.75, 5.75], [1.5, 3.5], [4.75, 5.75]]),
    ] {
        run(&folder, &format!("-q export m.sinew --clip {file} {more} -o out.glb"));
        let played = Glb::read(&folder, "out.glb");
        for (clip, expected) in expected.iter().enumerate() {
            assert_eq!(ends(&played, clip), *expected, "{file} {more}");
        }
    }
    let (source, played) = (Glb::read(&folder, "two.glb"), Glb::read(&folder, "out.glb"));
    for clip in [0, 1] {
        let off = off((&source, "tube", clip), (&played, "tube", 2 + clip));
        assert!(off <= 1e-3, "{off}");
    }
}

#[test]
fn binds_define_the_rest_pose_and_nodes_do_not() {
    let cases = ["gltf/plain.glb", "gltf/posed_tip.glb"];
    let Some(folder) = with_cases("posed", &cases) else { return };
    run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    // The file without its mesh, as animations are usually exchanged: the skin stays.
    let mut bare = Glb::read(&folder, "posed_tip.glb");
    bare.json["nodes"][3] = json!({ "name": "tube" });
    bare.write(&folder, "bare.glb");
    let source = Glb::read(&folder, "posed_tip.glb");
    for command in [
        "--clip posed_tip.glb --into plain.glb",
        "--clip posed_tip.glb --mesh plain.glb",
        "--clip bare.glb --mesh plain.glb",
        "--clip bare.glb --into plain.glb",
    ] {
        run(&folder, &format!("-q export m.sinew {command} -o out.glb"));
        let played = Glb::read(&folder, "out.glb");
        let clip = played.json["animations"].as_array().unwrap().len() - 1;
        let off = off((&source, "tube", 0), (&played, "tube", clip));
        assert!(off <= 1e-3, "{command}: {off}");
    }
}

#[test]
fn without_its_rest_pose_a_clip_plays_unless_a_joint_stretches() {
    let Some(folder) = with_cases("unbound", &["gltf/plain.glb"]) else { return };
    run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    let mut bare = Glb::read(&folder, "plain.glb");
    bare.json["nodes"][1]["rotation"] = json!([0.6, 0.0, 0.0, 0.8]);
    bare.json["nodes"][3] = json!({ "name": "tube" });
    bare.json.as_object_mut().unwrap().remove("skins");
    bare.write(&folder, "bare.glb");
    let export = "export m.sinew --clip bare.glb --mesh plain.glb -o out.glb";
    run(&folder, &format!("-q {export}"));
    let (source, played) = (Glb::read(&folder, "plain.glb"), Glb::read(&folder, "out.glb"));
    assert!(off((&source, "tube", 0), (&played, "tube", 0)) <= 1e-3);
    // Without a pose at rest nobody knows which stretch is none.
    let times = bare.floats("SCALAR", 1, &[0.0, 0.5]);
    let factors = bare.floats("VEC3", 3, &[1.0, 1.0, 1.0, 1.0, 1.5, 1.0]);
    let clip = &mut bare.json["animations"][0];
    let samplers = clip["samplers"].as_array_mut().unwrap();
    samplers.push(json!({ "input": times, "output": factors }));
    let target = json!({ "node": 2, "path": "scale" });
    let channel = json!({ "sampler": samplers.len() - 1, "target": target });
    clip["channels"].as_array_mut().unwrap().push(channel);
    bare.write(&folder, "bare.glb");
    let line = refused(&folder, export);
    assert!(line.contains("its joints at rest are not the character's: off by "), "{line}");
}

#[test]
fn a_prefix_is_named_with_the_option_that_takes_it_away() {
    let cases = ["gltf/plain.glb", "gltf/clipprefixed.glb"];
    let Some(folder) = with_cases("prefixed", &cases) else { return };
    run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    let export = "export m.sinew --clip clipprefixed.glb -o out.glb";
    let words =
        "begin with mixamorig:, the character's without a prefix: give --rename-joints mixamorig:=";
    for more in ["", " --mesh plain.glb", " --into plain.glb"] {
        let line = refused(&folder, &format!("{export}{more}"));
        assert!(line.contains(words), "{line}");
    }
    // The clip plays the rotations of plain.glb in reverse.
    let source = Glb::read(&folder, "clipprefixed.glb");
    let mut expected = Glb::read(&folder, "plain.glb");
    let times: Vec<f32> = source.times(0, 0).iter().map(|&x| x as f32).collect();
    let times = expected.floats("SCALAR", 1, &times);
    for channel in source.json["animations"][0]["channels"].as_array().unwrap() {
        let node = channel["target"]["node"].as_u64().unwrap() as usize;
        let own = &source.json["animations"][0]["samplers"]
            [channel["sampler"].as_u64().unwrap() as usize];
        let turns: Vec<f32> = source.values(&own["output"]).iter().map(|&x| x as f32).collect();
        let turns = expected.floats("VEC4", 4, &turns);
        expected.json["animations"][0]["samplers"][node] =
            json!({ "input": times, "output": turns });
    }
    let with = |prefix: &str, name: &str| {
        let mut glb = Glb::read(&folder, "clipprefixed.glb");
        for (node, own) in ["root", "mid", "tip"].iter().enumerate() {
            glb.json["nodes"][node]["name"] = json!(format!("{prefix}{own}"));
        }
        glb.write(&folder, name);
    };
    with("rig|a.", "other.glb");
    with("Upper_", "upper.glb");
    let mut cased = Glb::read(&folder, "clipprefixed.glb");
    for (node, name) in ["Root", "MID", "tip"].iter().enumerate() {
        cased.json["nodes"][node]["name"] = json!(name);
    }
    cased.write(&folder, "cased.glb");
    for (file, option) in [
        ("clipprefixed.glb", "--rename-joints mixamorig:="),
        ("other.glb", "--rename-joints rig|a.="),
        ("upper.glb", "--rename-joints Upper_="),
        ("cased.glb", "--ignore-case"),
    ] {
        for target in ["--mesh plain.glb", "--into plain.glb"] {
            let command = format!("export m.sinew --clip {file} {target} -o out.glb");
            let line = refused(&folder, &command);
            let quoted = option.replace("rig|a.=", "'rig|a.='");
            assert!(line.contains(&format!("give {quoted}")), "{line}");
            run(&folder, &format!("-q {command} {option}"));
            let played = Glb::read(&folder, "out.glb");
            let clip = played.json["animations"].as_array().unwrap().len() - 1;
            let off = off((&expected, "tube", 0), (&played, "tube", clip));
            assert!(off <= 1e-3, "{command}: {off}");
        }
    }
}

#[test]
fn an_artist_s_file_or_a_clip_with_a_mesh_may_have_prefixes_too() {
    let Some(folder) = with_cases("prefixed-mesh", &["gltf/plain.glb"]) else { return };
    run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    let mut glb = Glb::read(&folder, "plain.glb");
    for (node, own) in ["root", "mid", "tip"].iter().enumerate() {
        glb.json["nodes"][node]["name"] = json!(format!("x:{own}"));
    }
    glb.write(&folder, "prefixed.glb");
    let source = Glb::read(&folder, "plain.glb");
    for command in [
        "export m.sinew --clip prefixed.glb -o out.glb",
        "export m.sinew --clip plain.glb --into prefixed.glb -o out.glb",
        "export m.sinew --clip prefixed.glb --into prefixed.glb -o out.glb",
        "export m.sinew --clip plain.glb --mesh prefixed.glb -o out.glb",
    ] {
        let line = refused(&folder, command);
        assert!(line.contains("give --rename-joints x:="), "{line}");
        run(&folder, &format!("-q {command} --rename-joints x:="));
        let played = Glb::read(&folder, "out.glb");
        let clip = played.json["animations"].as_array().unwrap().len() - 1;
        let off = off((&source, "tube", 0), (&played, "tube", clip));
        assert!(off <= 1e-3, "{command}: {off}");
    }
}

#[test]
fn a_character_under_a_small_scale_is_exported() {
    let Some(folder) = with_cases("small", &["gltf/plain.glb"]) else { return };
    let mut glb = Glb::read(&folder, "plain.glb");
    for (scale, turn) in
        [(0.01, [-0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()]), (0.1, [0.0, 0.0, 0.0, 1.0])]
    {
        glb.json["nodes"][4]["scale"] = json!([scale, scale, scale]);
        glb.json["nodes"][4]["rotation"] = json!(turn);
        glb.write(&folder, "small.glb");
        let off = off_as_exported(&folder, "small.glb");
        assert!(off.iter().all(|&off| off <= 1e-3), "{scale}: {off:?}");
    }
}

#[test]
fn a_turn_of_the_root_joint_is_a_pose_and_not_another_orientation() {
    let Some(folder) = with_cases("posed-root", &["gltf/plain.glb"]) else { return };
    let mut glb = Glb::read(&folder, "plain.glb");
    for (axis, degrees) in [(0, 60_f64), (1, 50.0), (0, 90.0), (2, 170.0)] {
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        let mut turn = [0.0, 0.0, 0.0, cos];
        turn[axis] = sin;
        glb.json["nodes"][0]["rotation"] = json!(turn);
        glb.write(&folder, "posed.glb");
        let off = off_as_exported(&folder, "posed.glb");
        assert!(off.iter().all(|&off| off <= 1e-3), "{degrees}° about axis {axis}: {off:?}");
    }
}

#[test]
fn helpers_have_more_keys_where_they_bend() {
    let Some(folder) = with_cases("bending", &["gltf/plain.glb"]) else { return };
    let glb = Glb::read(&folder, "plain.glb");
    let keys = glb.times(0, 0);
    let turns = glb.values(&glb.json["animations"][0]["samplers"][1]["output"]);
    let rest = glb.posed("tube", None);
    let mut cache = b"POINTCACHE2\0".to_vec();
    cache.extend([1, rest.len() as i32].map(i32::to_le_bytes).concat());
    cache.extend([0.0, 1.0].map(f32::to_le_bytes).concat());
    cache.extend((keys.len() as i32).to_le_bytes());
    for (key, turn) in keys.iter().zip(turns.chunks(4)) {
        let angle = 2.0 * turn[3].abs().min(1.0).acos();
        for (mut x, at_rest) in glb.posed("tube", Some((0, *key))).into_iter().zip(&rest) {
            x.z += 0.4 * angle * angle * (-(4.0 * (at_rest.y - 1.0)).powi(2)).exp();
            cache.extend(x.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
    }
    std::fs::write(folder.path("bulge.pc2"), cache).unwrap();
    run(
        &folder,
        "-q train plain.glb --targets bulge.pc2 --predictor kernel --proxies 10 -o m.sinew",
    );
    run(&folder, "-q export m.sinew --clip plain.glb -o out.glb");
    run(&folder, "-q export m.sinew --clip plain.glb --fps 400 -o dense.glb");
    let [played, dense] = ["out.glb", "dense.glb"].map(|file| Glb::read(&folder, file));
    let found = played.times(0, 0).len();
    assert!((keys.len() + 1..8 * keys.len()).contains(&found), "{found} keys of {}", keys.len());
    // The model predicts each of the 400 frames per second, and nothing between them.
    for time in dense.times(0, 0) {
        let [own, truth] = [&played, &dense].map(|glb| glb.posed("tube", Some((0, time))));
        let off = apart(&truth, &own);
        assert!(off <= 0.1, "{off} % at {time}");
    }
}
