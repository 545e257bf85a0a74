//! Cases of the folder `gltf`: reading.

use super::glb::Glb;
use super::{apart, lbs, moments, off, off_as_exported, refused, run, with_cases};
use serde_json::{Value, json};

#[test]
fn a_plain_linear_skin_is_exact() {
    let Some(folder) = with_cases("plain", &["gltf/plain.glb"]) else { return };
    let error = lbs(&folder, "plain.glb");
    assert!(error <= 1e-4, "{error}");
    let off = off_as_exported(&folder, "plain.glb");
    assert!(off.iter().all(|&off| off <= 1e-3), "{off:?}");
}

#[test]
fn default_morph_weights_belong_to_the_rest_shape() {
    let Some(folder) = with_cases("morphdefault", &["gltf/morphdefault.glb"]) else { return };
    let mut node = Glb::read(&folder, "morphdefault.glb");
    // The node's weights override the mesh's.
    node.json["nodes"][3]["weights"] = json!([0.4]);
    node.write(&folder, "node.glb");
    // A target that displaces few vertices, and another target with weight 0.
    let mut sparse = Glb::read(&folder, "morphdefault.glb");
    let at = sparse.numbers(&[5, 60, 61]);
    let by = sparse.floats("VEC3", 3, &[0.0, 0.3, 0.0, 0.1, 0.0, 0.2, 0.0, 0.0, 0.4]);
    let view = |glb: &Glb, accessor: usize| glb.json["accessors"][accessor]["bufferView"].clone();
    let of_sparse = json!({
        "componentType": 5126, "type": "VEC3", "count": 132,
        "sparse": { "count": 3, "indices": { "bufferView": view(&sparse, at), "componentType": 5123 },
            "values": { "bufferView": view(&sparse, by) } },
    });
    let accessors = sparse.json["accessors"].as_array_mut().unwrap();
    accessors.push(of_sparse);
    let morph = accessors.len() - 1;
    let mesh = &mut sparse.json["meshes"][0];
    mesh["weights"] = json!([0.0, 0.5]);
    mesh["primitives"][0]["targets"].as_array_mut().unwrap().push(json!({ "POSITION": morph }));
    sparse.write(&folder, "sparse.glb");
    for file in ["morphdefault.glb", "node.glb", "sparse.glb"] {
        let error = lbs(&folder, file);
        assert!(error <= 1e-4, "{file}: {error}");
        let off = off_as_exported(&folder, file);
        assert!(off.iter().all(|&off| off <= 1e-3), "{file}: {off:?}");
    }
}

#[test]
fn a_channel_without_a_node_is_left_out() {
    let Some(folder) = with_cases("animpointer", &["gltf/animpointer.glb"]) else { return };
    let message = run(&folder, "check animpointer.glb").err;
    assert!(message.contains("animation channels without a node are left out, of the clips: move"));
    assert!(lbs(&folder, "animpointer.glb") <= 1e-4);
    let mut glb = Glb::read(&folder, "animpointer.glb");
    glb.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    glb.write(&folder, "required.glb");
    run(&folder, "check required.glb");
    // A clip with only such channels moves nothing.
    let channels = glb.json["animations"][0]["channels"].as_array_mut().unwrap();
    channels.retain(|channel| channel["target"].get("node").is_none());
    glb.write(&folder, "alone.glb");
    let line = refused(&folder, "check alone.glb");
    assert!(line.contains("no animation targets a joint"), "{line}");
}

#[test]
fn an_empty_scene_is_called_empty() {
    let Some(folder) = with_cases("empty", &["gltf/plain.glb"]) else { return };
    for (name, scenes) in [("none", json!([{}])), ("list", json!([{ "nodes": [] }]))] {
        let mut glb = Glb::read(&folder, "plain.glb");
        glb.json["scenes"] = scenes;
        glb.write(&folder, &format!("{name}.glb"));
        let line = refused(&folder, &format!("check {name}.glb"));
        assert!(line.contains("is empty: its scene shows no node"), "{line}");
    }
    std::fs::write(folder.path("bare.gltf"), r#"{ "asset": { "version": "2.0" } }"#).unwrap();
    run(&folder, "-q train --predictor kernel plain.glb -o m.sinew");
    for command in [
        "check bare.gltf",
        "train plain.glb --targets bare.gltf -o n.sinew",
        "train plain.glb --also bare.gltf -o n.sinew",
        "export m.sinew --clip bare.gltf --mesh plain.glb -o o.glb",
        "export m.sinew --clip plain.glb --into bare.gltf -o o.glb",
    ] {
        assert!(refused(&folder, command).contains("is empty"), "{command}");
    }
}

#[test]
fn vertices_without_weights_are_learned_from_the_targets() {
    let cases = ["gltf/zeroweights.glb", "gltf/plain_targets.npz"];
    let Some(folder) = with_cases("zeroweights", &cases) else { return };
    let line = refused(&folder, "train zeroweights.glb -o m.sinew");
    assert!(line.contains("vertex 40 has no joint weight"), "{line}");
    let message = run(&folder, "train zeroweights.glb --targets plain_targets.npz -o m.sinew").err;
    assert!(message.contains("vertices without a joint's weight, which follow the targets: 10"));
    let found = run(&folder, "-q eval m.sinew zeroweights.glb --targets plain_targets.npz --json");
    let found: Value = serde_json::from_str(&found.out).unwrap();
    assert!(found["rms_percent"].as_f64().unwrap() <= 1e-3, "{}", found["rms_percent"]);
}

#[test]
fn joints_of_equal_names_are_distinguished() {
    let Some(folder) = with_cases("samenames", &["gltf/pairsamenames.glb"]) else { return };
    assert!(lbs(&folder, "pairsamenames.glb") <= 1e-4);
    let message = run(&folder, "train --predictor kernel pairsamenames.glb -o m.sinew").err;
    assert!(
        message.contains(
            "equal names were renamed: root/mid, root/tip, root 2, root 2/mid, root 2/tip"
        ),
        "{message}"
    );
    let source = Glb::read(&folder, "pairsamenames.glb");
    // An animation without meshes has the joints' names too.
    let mut bare = Glb::read(&folder, "pairsamenames.glb");
    for mesh in [3, 8] {
        bare.json["nodes"][mesh] = json!({ "name": "gone" });
    }
    bare.write(&folder, "bare.glb");
    for command in [
        "--clip pairsamenames.glb",
        "--clip pairsamenames.glb --into pairsamenames.glb",
        "--clip bare.glb --mesh pairsamenames.glb",
    ] {
        run(&folder, &format!("-q export m.sinew {command} -o out.glb"));
        let played = Glb::read(&folder, "out.glb");
        let clip = played.json["animations"].as_array().unwrap().len() - 1;
        for mesh in ["tube", "tube2"] {
            let off = off((&source, mesh, 0), (&played, mesh, clip));
            assert!(off <= 1e-3, "{command}, {mesh}: {off}");
        }
    }
}

#[test]
fn a_scaled_joint_that_moves_nothing_is_no_matter() {
    let cases = ["gltf/scaled_socket.glb", "gltf/plain.glb"];
    let Some(folder) = with_cases("socket", &cases) else { return };
    assert!(lbs(&folder, "scaled_socket.glb") <= 1e-4);
    let message = run(&folder, "train --predictor kernel scaled_socket.glb -o m.sinew").err;
    assert!(
        message.contains("scaled joints that move no vertex are taken without their scale: socket"),
        "{message}"
    );
    // A child joint that moves nothing either.
    let mut child = Glb::read(&folder, "scaled_socket.glb");
    let binds = child.json["skins"][0]["inverseBindMatrices"].clone();
    let mut binds: Vec<f32> = child.values(&binds).iter().map(|&x| x as f32).collect();
    let own = binds[3 * 16..].to_vec();
    binds.extend(own);
    let binds = child.floats("MAT4", 16, &binds);
    let nodes = child.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "held" }));
    let held = nodes.len() - 1;
    nodes[5]["children"] = json!([held]);
    child.json["skins"][0] = json!({ "joints": [0, 1, 2, 5, held], "inverseBindMatrices": binds });
    child.write(&folder, "child.glb");
    assert!(lbs(&folder, "child.glb") <= 1e-4);
    for file in ["child.glb", "scaled_socket.glb"] {
        let off = off_as_exported(&folder, file);
        assert!(off.iter().all(|&off| off <= 1e-3), "{file}: {off:?}");
    }
    run(&folder, "-q export m.sinew --clip scaled_socket.glb --mesh scaled_socket.glb -o out.glb");
    // A socket that carries vertices scales them.
    let mut bound = Glb::read(&folder, "scaled_socket.glb");
    let joints: Vec<u8> = vec![[3, 1, 2, 0]; 132].concat();
    let joints = bound.add("VEC4", 5121, 132, &joints);
    bound.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    bound.write(&folder, "bound.glb");
    assert!(lbs(&folder, "bound.glb") <= 1e-4);
}

#[test]
fn joints_that_stretch_are_told_from_a_growing_character() {
    let Some(folder) = with_cases("squash", &["gltf/squash_leaf.glb"]) else { return };
    assert!(lbs(&folder, "squash_leaf.glb") <= 1e-4);
    // The root grows, the joint above it stretches, and the mesh is in centimetres.
    let mut glb = Glb::read(&folder, "squash_leaf.glb");
    let keys: Vec<f32> = (0..13).map(|key| key as f32 / 12.0).collect();
    let growth: Vec<f32> = keys.iter().flat_map(|key| [1.0 + 0.6 * key; 3]).collect();
    let stretch: Vec<f32> = keys.iter().flat_map(|key| [1.0, 1.0 + 0.4 * key * key, 1.0]).collect();
    let added = [glb.floats("VEC3", 3, &growth), glb.floats("VEC3", 3, &stretch)];
    let clip = &mut glb.json["animations"][0];
    for (node, output) in added.into_iter().enumerate() {
        let samplers = clip["samplers"].as_array_mut().unwrap();
        samplers.push(json!({ "input": 5, "output": output }));
        let sampler = samplers.len() - 1;
        let target = json!({ "node": node, "path": "scale" });
        clip["channels"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "sampler": sampler, "target": target }));
    }
    glb.write(&folder, "grows.glb");
    glb.json["nodes"][4]["scale"] = json!([0.01, 0.01, 0.01]);
    glb.write(&folder, "centimetres.glb");
    let positions = glb.values(&json!(0));
    let extent = [0, 1, 2].map(|axis| {
        let all = positions.iter().skip(axis).step_by(3).copied();
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    });
    let size = extent.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (file, metres) in [("grows.glb", 1.0), ("centimetres.glb", 0.01)] {
        assert!(lbs(&folder, file) <= 1e-4, "{file}");
        let message = run(&folder, &format!("train --predictor kernel {file} -o m.sinew")).err;
        let words = "joint root scales the whole character in 12 frames, by up to 1.6000";
        assert!(message.contains(words), "{message}");
        let found = run(&folder, &format!("-q eval m.sinew {file} --json")).out;
        let found: Value = serde_json::from_str(&found).unwrap();
        let diagonal = found["diagonal_mm"].as_f64().unwrap() / metres;
        assert!((diagonal / (1000.0 * size) - 1.0).abs() < 1e-4, "{file}: {diagonal}, {size}");
    }
}

/// The tube's rings become strips and its ends fans, with stitches and restarts.
#[test]
fn strips_and_fans_are_triangles() {
    let Some(folder) = with_cases("strips", &["gltf/plain.glb"]) else { return };
    let mut glb = Glb::read(&folder, "plain.glb");
    let indices = glb.values(&glb.json["meshes"][0]["primitives"][0]["indices"].clone());
    let triangles: Vec<[u16; 3]> =
        indices.as_chunks::<3>().0.iter().map(|corners| corners.map(|x| x as u16)).collect();
    let (as_strip, as_fan) = triangles.split_at(triangles.len() / 2);
    // Each triangle starts at an even index: repeated corners at both ends join it to the next.
    let mut strip: Vec<u16> = Vec::new();
    for (number, &[a, b, c]) in as_strip.iter().enumerate() {
        match number % 3 {
            0 if number > 0 => strip.extend([u16::MAX, a, b, c]),
            _ if strip.is_empty() => strip.extend([a, b, c]),
            _ => {
                let since = strip.iter().rev().take_while(|&&x| x != u16::MAX).count();
                let last = strip[strip.len() - 1];
                strip.push(last);
                if since % 2 == 1 {
                    strip.push(a);
                }
                strip.extend([a, a, b, c]);
            }
        }
    }
    let fans: Vec<u16> = as_fan.iter().flat_map(|&[a, b, c]| [c, a, b, u16::MAX]).collect();
    let [strip, fans] = [glb.numbers(&strip), glb.numbers(&fans)];
    let mut primitive = glb.json["meshes"][0]["primitives"][0].clone();
    primitive["mode"] = json!(5);
    primitive["indices"] = json!(strip);
    let mut second = primitive.clone();
    second["mode"] = json!(6);
    second["indices"] = json!(fans);
    glb.json["meshes"][0]["primitives"] = json!([primitive, second]);
    glb.write(&folder, "strips.glb");
    assert!(lbs(&folder, "strips.glb") <= 1e-4);
    let record = run(&folder, "-q train --predictor kernel strips.glb -o m.sinew --json").out;
    let record: Value = serde_json::from_str(&record).unwrap();
    // The vertices of both primitives, welded.
    assert_eq!(record["vertices"], 132);
    run(&folder, "-q export m.sinew --clip strips.glb -o out.glb");
    let played = Glb::read(&folder, "out.glb");
    let corners = &played.json["meshes"][0]["primitives"][0]["indices"];
    let corners = played.values(corners);
    let found = corners.as_chunks::<3>().0.iter().map(|c| {
        // Smallest index first: rotating a triangle's corners does not change the triangle.
        let mut own = c.map(|x| x as u16 % 132);
        let least = (0..3).min_by_key(|&k| own[k]).unwrap();
        own.rotate_left(least);
        own
    });
    let mut found: Vec<[u16; 3]> = found.collect();
    let mut expected = triangles.clone();
    for own in &mut expected {
        let least = (0..3).min_by_key(|&k| own[k]).unwrap();
        own.rotate_left(least);
    }
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn points_and_lines_beside_triangles_are_ignored_and_reported() {
    let Some(folder) = with_cases("lines", &["gltf/plain.glb"]) else { return };
    let mut glb = Glb::read(&folder, "plain.glb");
    let edges = glb.numbers(&[0, 1, 1, 2, 130, 131]);
    let mut lines = glb.json["meshes"][0]["primitives"][0].clone();
    lines["mode"] = json!(1);
    lines["indices"] = json!(edges);
    // A point next to the tube, with separate weights.
    let place = glb.floats("VEC3", 3, &[0.35, 1.9, 0.0]);
    let joints = glb.add("VEC4", 5121, 1, &[2, 0, 0, 0]);
    let weights = glb.floats("VEC4", 4, &[1.0, 0.0, 0.0, 0.0]);
    let point = json!({ "mode": 0, "attributes":
        { "POSITION": place, "JOINTS_0": joints, "WEIGHTS_0": weights } });
    let primitives = glb.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.insert(0, point);
    primitives.push(lines);
    glb.write(&folder, "lines.glb");
    let message = run(&folder, "train --predictor kernel lines.glb -o m.sinew").err;
    assert!(message.contains("points and lines are left out, of the meshes: tube"), "{message}");
    assert!(lbs(&folder, "lines.glb") <= 1e-4);
    let source = Glb::read(&folder, "lines.glb");
    run(&folder, "-q export m.sinew --clip lines.glb --into lines.glb -o out.glb");
    let played = Glb::read(&folder, "out.glb");
    for time in moments(&source, 0) {
        let [own, found] =
            [(&source, 0), (&played, 1)].map(|(glb, clip)| glb.posed("tube", Some((clip, time))));
        assert!(apart(&own[1..], &found[1..]) <= 1e-3);
        // The point follows its nearest vertex.
        assert!((own[0] - found[0]).norm() < 0.3);
    }
    for primitive in glb.json["meshes"][0]["primitives"].as_array_mut().unwrap() {
        primitive["mode"] = json!(3);
    }
    glb.write(&folder, "alone.glb");
    let line = refused(&folder, "train alone.glb -o m.sinew");
    assert!(line.contains("mesh tube is made of linestrip: export it as triangles"), "{line}");
}
